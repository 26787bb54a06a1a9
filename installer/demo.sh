#!/usr/bin/env bash
# installer/demo.sh [MESH]: from a bare Debian 12 to a sculpted piece. A simulated stylus, held by a simulated hand, carves
# a block (or the mesh given) through the real servo in real time; pictures before and after, an STL and a table of
# figures are left in build/demo.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/prepare.sh"

[ $# -le 1 ] || fail "demo.sh takes one mesh at most, $# arguments were given"
mesh=""
if [ $# = 1 ]; then
  [ -f "$1" ] || fail "$1 is not a file; give an STL, OBJ, PLY or OFF mesh, or nothing for a block"
  mesh="$(realpath "$1")"
fi

installPackages
buildPreset release argil

argil="$root/build/release/bin/argil"
out="$root/build/demo"
mkdir -p "$out"
say "sculpting ${mesh:-a block}"
"$argil" sculpt "$root/installer/demo.json" --live ${mesh:+-i "$mesh"} -o "$out/after.stl" \
  --before-png "$out/before.png" --png "$out/after.png" --report "$out/report.json" --overwrite
say "before.png, after.png, after.stl and report.json are in $out"
