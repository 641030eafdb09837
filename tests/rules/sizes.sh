#!/usr/bin/env bash
# No file of ours is longer than 400 lines, and none names a machine's own folders.
# Usage: sizes.sh HOME
set -euo pipefail
cd "$1"

mapfile -t files < <(find shared protocol arm_controller host tools tests \
  \( -name '*.cpp' -o -name '*.hpp' -o -name '*.proto' -o -name '*.sh' -o -name '*.cmake' -o -name 'CMakeLists.txt' \) -not -path '*/node_modules/*' | sort)
failures=0
for file in "${files[@]}"; do
  lines=$(wc -l <"$file")
  if [[ $lines -gt 400 ]]; then
    echo "$file: $lines lines; must be at most 400"
    failures=$((failures + 1))
  fi
done
if found=$(grep -nE '["=( ]/(home|root|Users|work|mnt|opt)/' "${files[@]}" | grep -v '^tests/rules/sizes.sh'); then
  printf 'folders of one machine:\n%s\n' "$found"
  failures=$((failures + 1))
fi
exit "$((failures > 0))"
