#!/usr/bin/env bash
# The arm computer's half configures where neither OpenCV nor Ceres can be found.
# Usage: configure_alone.sh HOME
set -euo pipefail

tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
hidden=()
for package in OpenCV Ceres CLI11 nlohmann_json GTest benchmark; do hidden+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON"); done
cmake -S "$1" -B "$tree" -G Ninja -DARMSIGHT_BUILD_HOST=OFF -DARMSIGHT_BUILD_TESTS=OFF "${hidden[@]}" >"$tree/log" 2>&1 ||
  { tail -n 20 "$tree/log"; exit 1; }
ninja -C "$tree" -t query arm_controller >/dev/null
