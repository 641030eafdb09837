#!/usr/bin/env bash
# No file of ours is longer than 400 lines, and none names a machine's own folders.
# Usage: sizes.sh HOME
set -euo pipefail
cd "$1"

mapfile -t files < <(find shared protocol arm_controller host tools tests \
  \( -name '*.cpp' -o -name '*.hpp' -o -name '*.proto' -o -name '*.sh' -o -name '*.cmake' -o -name 'CMakeLists.txt' \) -not -path '*/node_modules/*' | sort)
failures=0
if long=$(wc -l "${files[@]}" | awk '$2 != "total" && $1 > 400 {print "  " $2 ": " $1 " lines"}' | grep .); then
  printf 'longer than 400 lines:\n%s\n' "$long"
  failures=$((failures + 1))
fi
if found=$(grep -nE '["=( ]/(home|root|Users|work|mnt|opt)/' "${files[@]}" | grep -v '^tests/rules/sizes.sh'); then
  printf 'folders of one machine:\n%s\n' "$found"
  failures=$((failures + 1))
fi
exit "$((failures > 0))"
