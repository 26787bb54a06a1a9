#!/usr/bin/env bash
# scripts/docs.sh: renders the contact sheet of all tools, docs/tools.png, with the release build, and writes the page on scripts, docs/scripts.md. Needs ImageMagick.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
argil="$root/build/release/bin/argil"
tiles="$(mktemp -d)"
trap 'rm -rf "$tiles"' EXIT
# What stamps and embosses: a ring of rays as grey levels, and a star of clay.
convert -size 256x256 xc:black -fill white -draw "circle 128,128 128,24" -fill black -draw "circle 128,128 128,64" -fill white -draw "circle 128,128 128,100" \
  -stroke white -strokewidth 10 -draw "line 128,10 128,246" -draw "line 10,128 246,128" -draw "line 45,45 211,211" -draw "line 211,45 45,211" -blur 0x3 "$tiles/tile.pgm"
cat > "$tiles/star.json" <<'JSON'
{"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.25}, {"sphere": {"radius_mm": 3}}], "strokes": [
 {"tool": "add", "radius_mm": 1.6, "path": [[0, -9, 0, 0], [1, 9, 0, 0]]},
 {"tool": "add", "radius_mm": 1.6, "path": [[0, -4.5, -7.8, 0], [1, 4.5, 7.8, 0]]},
 {"tool": "add", "radius_mm": 1.6, "path": [[0, -4.5, 7.8, 0], [1, 4.5, -7.8, 0]]}]}
JSON
"$argil" sculpt "$tiles/star.json" -o "$tiles/tile.stl" > /dev/null
labels=()
while read -r id; do
  "$argil" tools --demo "$id" > "$tiles/$id.json"
  "$argil" sculpt "$tiles/$id.json" -o "$tiles/$id.argil" > /dev/null
  "$argil" render "$tiles/$id.argil" -o "$tiles/$id.png" --size 480x320 > /dev/null
  mogrify -gravity center -crop 76%x76%+0+0 +repage "$tiles/$id.png"
  labels+=(-label "$id" "$tiles/$id.png")
done < <("$argil" tools --ids)
montage "${labels[@]}" -tile 6x -geometry 240x160+4+4 -background '#202226' -fill '#d8d8d8' -depth 8 "$tiles/sheet.png"
convert "$tiles/sheet.png" -depth 8 -colors 255 "PNG8:${1:-$root/docs/tools.png}"

"$argil" tools --scripts > "$root/docs/scripts.md"
