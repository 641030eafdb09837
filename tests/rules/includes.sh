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

# YAML stays in its one reader, PF_CAN in its one file, Ceres in its two.
# only_in WHAT PATTERN FILE...: the pattern stands in exactly these files of the rooms.
rooms=("${shared[@]}" "${protocol[@]}" "${transport[@]}" "${controller[@]}" "${host[@]}")
only_in() {
  local what=$1 pattern=$2; shift 2
  local found
  found=$(grep -lE "$pattern" "${rooms[@]}" | sort | tr '\n' ' ')
  [[ ${found% } == "$*" ]] && return 0
  printf '%s: it stands in: %s, and belongs in: %s\n' "$what" "${found% }" "$*"
  breaches=$((breaches + 1))
}
only_in "yaml-cpp" '#[[:space:]]*include[[:space:]]*[<"]yaml-cpp/' protocol/strict_yaml.cpp
only_in "PF_CAN, AF_CAN" '\b[AP]F_CAN[,;]' arm_controller/socket_can.cpp
only_in "Ceres" '#[[:space:]]*include[[:space:]]*[<"]ceres/' host/batch_calibration_ceres.cpp host/batch_calibration_cost.hpp
exit "$((breaches > 0))"
