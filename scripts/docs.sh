#!/usr/bin/env bash
# scripts/docs.sh: renders the contact sheet of all tools, each before and after its stroke, docs/tools.png, with the release build, and writes the page on scripts, docs/scripts.md. Needs ImageMagick.
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
# picture SCRIPT PNG: from above, where the key light grazes the clay; cut out above the scale bar.
picture() {
  "$argil" sculpt "$1" -o "$tiles/clay.argil" --overwrite > /dev/null
  "$argil" render "$tiles/clay.argil" -o "$2" --size 720x480 --view top --overwrite > /dev/null
  mogrify -crop 584x355+68+38 +repage -resize 212x "$2"
}
labels=()
while read -r id; do
  "$argil" tools --demo "$id" > "$tiles/after.json"
  # The same without the tool's own strokes: lines behind the clay and the two strokes that make a bump and a furrow.
  awk -v own="{\"tool\":\"$id\"" 'NR <= 3 || index($0, own) != 1' "$tiles/after.json" | sed -e '$d' |
    sed -e '$s/,$/]}/' > "$tiles/before.json"
  picture "$tiles/before.json" "$tiles/before.png"
  picture "$tiles/after.json" "$tiles/after.png"
  convert "$tiles/before.png" "$tiles/after.png" +append "$tiles/$id.png"
  name="$("$argil" tools | sed -n "s/^  $id  *\(.*\)/\1/p" | sed 's/   *.*//')"
  labels+=(-label "$name" "$tiles/$id.png")
done < <("$argil" tools --ids)
montage "${labels[@]}" -tile 4x -geometry +5+5 -background '#202226' -fill '#d8d8d8' -depth 8 "$tiles/sheet.png"
convert "$tiles/sheet.png" -strip -depth 8 -quality 95 "PNG24:${1:-$root/docs/tools.png}"

"$argil" tools --scripts > "$root/docs/scripts.md"
