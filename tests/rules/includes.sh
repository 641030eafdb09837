#!/usr/bin/env bash
# Who may include whom (README of the rooms): each line of output is a breach.
# Usage: includes.sh HOME
set -euo pipefail
cd "$1"

breaches=0
# forbid WHAT PATTERN FILE...: no file may have an #include that matches.
forbid() {
  local what=$1 pattern=$2; shift 2
  local found
  found=$(grep -nE "^[[:space:]]*#[[:space:]]*include[[:space:]]*[<\"]($pattern)" "$@" /dev/null || true)
  [[ -z $found ]] && return 0
  printf '%s:\n%s\n' "$what" "$found"
  breaches=$((breaches + 1))
}
sources() { find "$@" -name '*.cpp' -o -name '*.hpp' | sort; }

mapfile -t shared < <(sources shared)
mapfile -t protocol < <(sources protocol | grep -v '^protocol/transport/')
mapfile -t transport < <(sources protocol/transport)
mapfile -t controller < <(sources arm_controller)
mapfile -t host < <(sources host)

forbid "shared/ knows Eigen and std only" 'protocol/|arm_controller/|host/|tools/|tests/|asio|google/|yaml-cpp|opencv|ceres|nlohmann|CLI/|sys/|unistd|thread>|mutex>|fstream>|iostream>' "${shared[@]}"
forbid "protocol/ has no sockets, threads, clocks" 'arm_controller/|host/|tools/|tests/|asio|opencv|ceres|sys/socket|netinet/|arpa/|sys/un\.h|linux/can|thread>|mutex>|condition_variable>|poll\.h|protocol/transport/' "${protocol[@]}"
forbid "protocol/transport/ knows neither program" 'arm_controller/|host/|tools/|tests/|opencv|ceres' "${transport[@]}"
forbid "arm_controller/ has nothing of host/, OpenCV, Ceres" 'host/|tools/|tests/|opencv|ceres|nlohmann|CLI/' "${controller[@]}"
forbid "host/ has nothing of arm_controller/" 'arm_controller/|tools/|tests/' "${host[@]}"

# YAML stays in its one reader, Ceres in its one file, PF_CAN in its one.
ceres=$(grep -lE '#include <ceres/' "${host[@]}" | wc -l)
[[ $ceres -le 2 ]] || { printf 'Ceres is included by %s files of host/; batch_calibration and its cost are enough\n' "$ceres"; breaches=$((breaches + 1)); }
exit "$((breaches > 0))"
