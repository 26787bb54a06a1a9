#!/usr/bin/env bash
# scripts/print_demo.sh [MESH [FOLDER]]: the whole way from a shape to a printer and to CAD. The mesh, or a ball,
# becomes clay 100 mm long, gets a base, is cut into two that find their place on each other by pegs, hollowed, drained
# and laid on a bed (scripts/print_demo.json); what stands in the way of printing it is told, and PrusaSlicer, where it
# is, slices the 3MF. The whole shape goes out as a STEP solid of smooth faces with its bound, for which OpenCASCADE is
# needed. Runs build/release/bin/argil, which installer/demo.sh builds, or what ARGIL names; files are left in FOLDER,
# build/print_demo when left out.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
argil="${ARGIL:-$root/build/release/bin/argil}"
mesh="${1:-}"
out="${2:-$root/build/print_demo}"

fail() {
  echo "print_demo.sh: $*" >&2
  exit 2
}
[ $# -le 2 ] || fail "a mesh and a folder at most, $# arguments were given"
[ -z "$mesh" ] || [ -f "$mesh" ] || fail "$mesh is not a file; give a mesh, or nothing for a ball"
[ -x "$argil" ] || fail "$argil is not there; installer/demo.sh builds it"
mkdir -p "$out"

echo "== to the printer"
"$argil" sculpt "$root/scripts/print_demo.json" ${mesh:+-i "$mesh"} \
  -o "$out/parts.argil" -o "$out/parts.3mf" --png "$out/parts.png" --overwrite
"$argil" inspect "$out/parts.argil" --print sla
if command -v prusa-slicer > /dev/null; then
  prusa-slicer --info "$out/parts.3mf" 2> /dev/null
  prusa-slicer --export-gcode --support-material --bed-shape 0x0,250x0,250x210,0x210 \
    --output "$out/parts.gcode" "$out/parts.3mf"
else
  echo "prusa-slicer is not installed: the 3MF was not sliced"
fi

echo "== to CAD"
sed 's/"strokes": \[/"strokes": []}/; /"operation"/d; /^ \]}$/d' "$root/scripts/print_demo.json" > "$out/whole.json"
"$argil" sculpt "$out/whole.json" ${mesh:+-i "$mesh"} -o "$out/whole.argil" --overwrite > /dev/null
"$argil" convert "$out/whole.argil" "$out/whole.step" --faces 1000 --overwrite
echo "parts.3mf, parts.png and whole.step are in $out"
