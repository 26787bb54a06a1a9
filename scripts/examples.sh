#!/usr/bin/env bash
# scripts/examples.sh [--dry]: applies the worked examples of CONTRIBUTING.md, docs/examples/*.diff, to a copy of this tree,
# builds argil there and runs what their lines "Shows: ..." say. With --dry: looks whether they apply, which changes nothing.
# Exit 1, and a line that names the example, when one does not.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
examples=("$root"/docs/examples/*.diff)
[ -f "${examples[0]}" ] || { echo "examples.sh: docs/examples has no example" >&2; exit 1; }

if [ "${1:-}" = --dry ]; then
  for example in "${examples[@]}"; do
    patch --dry-run --force --silent -p1 -d "$root" -i "$example" > /dev/null ||
      { echo "examples.sh: $(basename "$example") does not apply" >&2; exit 1; }
  done
  exit 0
fi

copy="$(mktemp -d)"
trap 'rm -rf "$copy"' EXIT
tar -C "$root" --exclude=./build --exclude=./.git -cf - . | tar -C "$copy" -xf -
for example in "${examples[@]}"; do patch --force --silent -p1 -d "$copy" -i "$example"; done
(cd "$copy" && cmake --preset release > /dev/null && cmake --build --preset release --target argil)
export PATH="$copy/build/release/bin:$PATH"
cd "$copy"
for example in "${examples[@]}"; do
  while IFS= read -r shows; do
    bash -o pipefail -c "$shows" > /dev/null ||
      { echo "examples.sh: $(basename "$example"): this does not show it: $shows" >&2; exit 1; }
  done < <(sed -n 's/^Shows: //p' "$example")
done
