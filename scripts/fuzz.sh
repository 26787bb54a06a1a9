#!/usr/bin/env bash
# scripts/fuzz.sh [SECONDS | RUNSx] [TARGET...]: builds the targets of tests/fuzz with libFuzzer and runs each, one after another, for so many
# seconds (60) or runs ("200000x"), beginning with its kept corpus. Prints executions for each target and in all; exit 1 when something crashed,
# hung (5 s for one input), leaked or took over 2 GB: the input is then in build/fuzz/found/. New inputs go to build/fuzz/corpus/;
# --merge instead takes from there what reaches new code, smallest first, into the kept corpora.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../installer/prepare.sh"

length=60 merge=false
case "${1:-}" in
  --merge) merge=true; shift ;;
  [0-9]*) length="$1"; shift ;;
esac
case "$length" in
  *[!0-9x]* | x* | *x?*) fail "fuzz.sh: give seconds such as 60, or runs such as 200000x" ;;
  *x) limit="-runs=${length%x}" ;;
  *) limit="-max_total_time=$length" ;;
esac

installPackages packages.txt packages-fuzz.txt
buildPreset fuzz
cd "$root/build/fuzz"
mkdir -p found
export ASAN_OPTIONS="detect_leaks=1:allocator_may_return_null=0" UBSAN_OPTIONS="print_stacktrace=1"

total=0 broken=0
for folder in "$root"/tests/fuzz/*/corpus/*/; do
  name="$(basename "$folder")"
  if [ "$#" != 0 ] && [[ " $* " != *" $name "* ]]; then continue; fi
  program="bin/fuzz_$name"
  [ -x "$program" ] || fail "tests/fuzz has a corpus for $name, but there is no target of that name"
  mkdir -p "corpus/$name"
  options=(-timeout=5 -rss_limit_mb=2048 -malloc_limit_mb=1024 -max_len=4096 -artifact_prefix="found/$name-")
  [ -s "${folder%/corpus/*}/$name.dict" ] && options+=(-dict="${folder%/corpus/*}/$name.dict")
  if $merge; then
    mkdir -p "merged/$name"
    rm -f "merged/$name"/*
    "$program" -merge=1 "${options[@]}" "merged/$name" "$folder" "corpus/$name" > "merge-$name.log" 2>&1 || fail "merging $name failed: see build/fuzz/merge-$name.log"
    say "$name: $(ls "merged/$name" | wc -l) of $(ls "$folder" "corpus/$name" | wc -l) inputs reach all of its code: build/fuzz/merged/$name"
    continue
  fi
  log="$name.log"
  status=0
  nice "$program" "${options[@]}" "$limit" -print_final_stats=1 "corpus/$name" "$folder" > "$log" 2>&1 || status=$?
  executions="$(awk '/^stat::number_of_executed_units/ { print $2 }' "$log")"
  total=$((total + ${executions:-0}))
  if [ "$status" = 0 ]; then
    printf '%-16s %12s executions\n' "$name" "$executions"
  else
    broken=$((broken + 1))
    printf '%-16s %12s executions, then BROKEN (exit %s): see build/fuzz/%s\n' "$name" "${executions:-?}" "$status" "$log"
  fi
done
$merge || printf 'in all %d executions, %d targets broken\n' "$total" "$broken"
[ "$broken" = 0 ]
