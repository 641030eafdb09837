#!/usr/bin/env bash
# No line of host/, tests/ and tools/ is longer than the 120 columns of .clang-format; raw strings hold other formats.
# Usage: columns.sh HOME
set -euo pipefail
cd "$1"
export LC_ALL=C

mapfile -t files < <(find host tests tools \( -name '*.cpp' -o -name '*.hpp' \) -not -path '*/node_modules/*' | sort)
if long=$(awk '
  FNR == 1 { is_raw = 0 }
  /R"[a-z]*\(/ { is_raw = 1 }
  { columns = $0; gsub(/[\200-\277]/, "", columns) }
  !is_raw && length(columns) > 120 { print "  " FILENAME ":" FNR ": " length(columns) " columns" }
  /\)[a-z]*"/ { is_raw = 0 }' "${files[@]}" | grep .); then
  printf 'longer than 120 columns:\n%s\n' "$long"
  exit 1
fi
