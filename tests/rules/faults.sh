#!/usr/bin/env bash
# Every Fault of arm_controller/fault.hpp has its paragraph in the room's README, and no paragraph is left over.
# Usage: faults.sh HOME
set -euo pipefail
cd "$1/arm_controller"

codes=$(sed -n 's/^ *\(k[A-Za-z]*\) = \([0-9][0-9]*\),.*/\2 \1/p' fault.hpp | grep -v '^0 ')
documented=$(sed -n 's/^\*\*\([0-9][0-9]*\) \(k[A-Za-z]*\)\..*/\1 \2/p' README.md)
[[ -n $codes ]] || { echo "no fault found in fault.hpp: has its form changed?"; exit 1; }
if ! difference=$(diff <(sort <<<"$codes") <(sort <<<"$documented")); then
  printf 'fault.hpp (<) and README.md (>) differ:\n%s\n' "$difference"
  exit 1
fi
