#!/usr/bin/env bash
# installer/test.sh [--long]: from a bare Debian 12 to every test run. Ends with one line such as "37 passed, 0 failed";
# exit 0 when nothing failed. Real models are read from the folder that ARGIL_DATA names; without it their tests are
# skipped. --long adds the long tests, both sanitizer builds and libFuzzer
# for some seconds a reader.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/prepare.sh"

long=false
for argument in "$@"; do
  case "$argument" in
    --long) long=true ;;
    *) fail "test.sh: unknown option $argument; the only one is --long" ;;
  esac
done

passed=0 failed=0 skipped=0
failures=""  # what failed and why, told once more at the end

# failuresOf REPORT: of each case that failed its name and the first lines of what it said.
failuresOf() {
  awk '
    function value(name) {
      return match($0, name "=\"[^\"]*\"") ? substr($0, RSTART + length(name) + 2, RLENGTH - length(name) - 3) : ""
    }
    /<testcase / { case_ = value("classname") "." value("name"); told = 0 }
    /<failure/ && !told { told = 1; text = value("message"); gsub(/&#x0A;/, "\n  ", text); gsub(/&quot;/, "\"", text)
      gsub(/&lt;/, "<", text); gsub(/&gt;/, ">", text); gsub(/&amp;/, "\\&", text)
      print case_ ": " substr(text, 1, 600) }' "$1"
}

# runTests PRESET [CTEST-OPTION...]: runs the preset's tests and adds their cases to the counts. A program that left no
# GoogleTest report (a crash, a script) counts as one case.
runTests() {
  local preset="$1" reports name status report cases bad idle
  shift
  reports="$root/build/$preset/reports"
  rm -rf "$reports"
  mkdir -p "$reports"
  say "running the tests of preset $preset"
  # More than two at once: many of them mostly wait.
  ctest --test-dir "$root/build/$preset" --output-on-failure -j6 --no-tests=error --output-junit "$reports/ctest.junit" \
    "$@" || true
  [ -s "$reports/ctest.junit" ] || fail "ctest of preset $preset left no report"
  while read -r name status; do
    report="$reports/$name.xml"
    cases=0 bad=0 idle=0
    if [ -s "$report" ]; then
      read -r cases bad idle < <(awk '
        /<testcase / { cases += /status="run"/ || /result="skipped"/; idle += /result="skipped"/; counted = 0 }
        /<failure/ && !counted { bad++; counted = 1 }
        END { print cases + 0, bad + 0, idle + 0 }' "$report")
      [ "$bad" = 0 ] || failures+="$(failuresOf "$report")"$'\n'
    fi
    if [ "$status" = run ]; then
      [ "$cases" -gt 0 ] || cases=1
    elif [ "$status" = fail ]; then
      [ "$bad" -gt 0 ] || { cases=$((cases + 1)) bad=1 failures+="$preset $name: ended without a report"$'\n'; }
    else
      cases=1 idle=1
    fi
    passed=$((passed + cases - bad - idle)) failed=$((failed + bad)) skipped=$((skipped + idle))
  done < <(sed -n 's/.*<testcase name="\([^"]*\)".* status="\([^"]*\)".*/\1 \2/p' "$reports/ctest.junit")
}

installPackages
buildPreset release
if [ -n "${ARGIL_DATA:-}" ]; then
  [ -d "$ARGIL_DATA" ] || fail "ARGIL_DATA is $ARGIL_DATA, which is no folder"
  ARGIL_DATA="$(realpath "$ARGIL_DATA")"  # the tests run elsewhere
  export ARGIL_DATA
  say "real models: $ARGIL_DATA"
else
  say "real models: ARGIL_DATA is not set, tests that read them are skipped"
fi

if $long; then
  export ARGIL_LONG=1
  runTests release
  say "memory and threads beside what is kept of this processor"
  if "$root/build/release/bin/argil" bench pairs --from "$root/docs/figures/pairs.csv"; then
    passed=$((passed + 1))
  else
    failed=$((failed + 1))
  fi
  buildPreset asan
  runTests asan
  # The system's TBB is not instrumented: the test programs run it on one thread, and the command line is left out.
  buildPreset tsan
  # Tests of power cuts fork while TBB's threads rest.
  export TSAN_OPTIONS="suppressions=$root/tests/support/tsan.supp die_after_fork=0"
  runTests tsan -E '^e2e'
  say "the worked examples of CONTRIBUTING.md"
  if "$root/scripts/examples.sh"; then passed=$((passed + 1)); else failed=$((failed + 1)); fi
  say "fuzzing every reader for a few seconds"
  if "$root/scripts/fuzz.sh" 10; then passed=$((passed + 1)); else failed=$((failed + 1)); fi
else
  # Suites named Long... are the soaks.
  GTEST_FILTER='-Long*' runTests release
fi

[ -z "$failures" ] || printf 'what failed:\n%s' "$failures"
summary="$passed passed, $failed failed"
[ "$skipped" = 0 ] || summary+=", $skipped skipped"
echo "$summary"
[ "$failed" = 0 ] && [ "$passed" -gt 0 ]
