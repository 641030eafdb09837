#!/usr/bin/env bash
# The arm computer's half builds where neither OpenCV nor Ceres can be found, and links neither.
# Short: it is configured so, beside a tree of the whole, with the whole's own flags. The commands that would build
# arm_controller there must be those that built it here, word for word; then what links.sh says of the program here it
# says of the one built alone. With --build it is compiled and linked all the same (some minutes: label long).
# Usage: build_alone.sh HOME BUILD_TREE [--build]
set -euo pipefail
home=$1 whole=$2

alone=$(mktemp -d)
trap 'rm -rf "$alone"' EXIT
own_choice='CMAKE_BUILD_TYPE|CMAKE_CXX_FLAGS[A-Z_]*|CMAKE_CXX_COMPILER|CMAKE_CXX_COMPILER_LAUNCHER|CMAKE_UNITY_BUILD'
own_choice+='|ARMSIGHT_PRECOMPILE|ARMSIGHT_SANITIZE|ARMSIGHT_WERROR'
given=()
while IFS= read -r line; do given+=("-D$line"); done < <(
  grep -E "^($own_choice):" "$whole/CMakeCache.txt")
for package in OpenCV Ceres CLI11 nlohmann_json GTest benchmark; do given+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON"); done
cmake -S "$home" -B "$alone" -G Ninja -DARMSIGHT_BUILD_HOST=OFF -DARMSIGHT_BUILD_TESTS=OFF "${given[@]}" >"$alone/log" 2>&1 ||
  { tail -n 20 "$alone/log"; exit 1; }

if [[ ${3:-} == --build ]]; then
  ninja -C "$alone" arm_controller >"$alone/log" 2>&1 || { tail -n 20 "$alone/log"; exit 1; }
  exec "$(dirname "${BASH_SOURCE[0]}")/links.sh" "$alone/bin/arm_controller"
fi
commands() { ninja -C "$1" -t commands arm_controller | sed "s#$1#TREE#g" | grep -v 'cmake --regenerate' | sort; }
commands "$alone" >"$alone/commands"
[[ $(grep -c ' -o ' "$alone/commands") -ge 10 ]] || { echo "ninja tells of fewer than 10 steps that build arm_controller"; exit 1; }
if ! difference=$(diff <(commands "$whole") "$alone/commands"); then
  printf 'arm_controller is built otherwise in the whole (<) than alone (>):\n%s\n' "$(cut -c1-600 <<<"$difference")"
  exit 1
fi
