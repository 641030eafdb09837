#!/usr/bin/env bash
# sabotage.sh SOURCE: every row of the fault catalogue has tests and a sabotage of one line that applies to the sources as
# they are; no test and no patch is without a row.
set -uo pipefail
cd "$1" || exit 1
# shellcheck source=tests/faults/catalogue.sh
source tests/faults/catalogue.sh
failures=0
say() { echo "$1"; failures=$((failures + 1)); }
command -v git >/dev/null || { echo "SKIPPED: no git"; exit 77; }

rows=$(catalogue tests/faults/README.md)
for row in $(seq 1 18); do
  [[ $(grep -c "^$row	" <<<"$rows") == 1 ]] || say "tests/faults/README.md: row $row is not there once"
done
while IFS=$'\t' read -r row suites patch; do
  for suite in $suites; do
    grep -qE "TEST(_F|_P)?\($suite," tests/faults/*_test.cpp || say "row $row: no test of $suite in tests/faults"
  done
  [[ -n $suites ]] || say "row $row names no tests"
  file=tests/sabotage/$patch.patch
  [[ -f $file ]] || { say "row $row: $file is missing"; continue; }
  git apply --check "$file" 2>&1 || say "row $row: $file does not apply any more: make it anew"
  added=$(grep -c '^+[^+]' "$file") removed=$(grep -c '^-[^-]' "$file")
  [[ $removed == 1 && $added -le 1 ]] || say "row $row: $file changes more than one line"
done <<<"$rows"
for suite in $(sed -nE 's/^TEST(_F|_P)?\((\w+),.*/\2/p' tests/faults/*_test.cpp | sort -u); do
  cut -f2 <<<"$rows" | tr ' ' '\n' | grep -qx "$suite" || say "$suite (tests/faults) is in no row of README.md"
done
for file in tests/sabotage/*.patch; do
  cut -f3 <<<"$rows" | grep -qx "$(basename "$file" .patch)" || say "$file is in no row of tests/faults/README.md"
done
exit $((failures > 0))
