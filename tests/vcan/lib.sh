# Shared by the scripts of this folder; sourced. Arguments: BIN_FOLDER SOURCE_FOLDER WORK_FOLDER.
programs=$1 source=$2 work=$3
test_name=$(basename "$0" .sh)
rate_hz=${ARMSIGHT_VCAN_RATE_HZ:-250} patience=${ARMSIGHT_VCAN_PATIENCE:-1}

fail() { echo "$test_name: $1"; exit 1; }
skip() {
  [[ ${ARMSIGHT_REQUIRE_VCAN:-0} == 1 ]] && fail "$1"
  echo "$test_name: SKIPPED: $1"
  exit 77
}
needs_vcan() { [[ -e /sys/class/net/vcan0 ]] || skip "no vcan0 here: run tools/hil"; }

# robot FILE: the shipped robot at the engine's rate.
robot() {
  awk -v rate="$rate_hz" -v patience="$patience" '
    function least(a, b) { return a < b ? a : b }
    /^  period_s:/ { $0 = "  period_s: " 1 / rate }
    /^  rpdo_deadline_s:/ { $0 = "  rpdo_deadline_s: " least(1, 0.1 * patience) }
    /^  heartbeat_s:/ { $0 = "  heartbeat_s: " least(5, 0.25 * patience) }
    /^  lease_s:/ { $0 = "  lease_s: " least(1, 0.2 * patience) }
    { print }' "$source/arm_controller/config/ego_right_arm.yaml" >"$1"
}

# fresh_work: an empty work folder with the robot file.
fresh_work() {
  rm -rf "$work"
  mkdir -p "$work/host"
  robot "$work/robot.yaml"
}

# begin NAME COMMAND...: in the background, its lines in NAME.log, its number in pid[NAME]; ended at the latest with the script.
declare -A pid=()
begin() {
  local name=$1
  shift
  "$@" >"$work/$name.log" 2>"$work/$name.err" &
  pid[$name]=$!
}
# end NAME [SIGNAL]: its exit code.
end() {
  local number=${pid[$1]}
  unset "pid[$1]"
  kill -s "${2:-TERM}" "$number" 2>/dev/null
  wait "$number"
}
end_all() {
  local name
  for name in "${!pid[@]}"; do end "$name" KILL 2>/dev/null; done
}
trap end_all EXIT

# await NAME PATTERN: until a line of its log holds the pattern.
await() {
  local i
  for ((i = 0; i < 600 * patience; ++i)); do
    grep -q "$2" "$work/$1.log" "$work/$1.err" && return 0
    kill -0 "${pid[$1]}" 2>/dev/null || break
    sleep 0.1
  done
  tail -n 5 "$work/$1.log" "$work/$1.err"
  fail "$1 did not say '$2'"
}

begin_controller() {
  mkdir -p "$work/controller"
  begin arm_controller "$programs/arm_controller" --config "$work/robot.yaml" --listen 127.0.0.1:0 --state "$work/controller" --can vcan0
  await arm_controller "listening on"
  link=$(sed -n 's/^arm_controller: listening on //p' "$work/arm_controller.log")
}
host() { "$programs/host" --arm "$link" --state "$work/host" --robot "$work/robot.yaml" "$@"; }

# begin_arm INTERFACE: the simulated robot there, its log in bus.log.
begin_arm() {
  begin arm_sim "$programs/arm_sim" --robot "$work/robot.yaml" --scene "$source/tools/sim/scene.yaml" --noise clean \
    --clock "$work/clock" --camera 127.0.0.1:0 --can "$1" --log "$work/bus.log"
  await arm_sim "arm_sim: ready"
}
begin_move() {
  begin host "$programs/host" --arm "$link" --state "$work/host" --robot "$work/robot.yaml" \
    move --joints=-1.3,0.5,-1.3,2.0,-1.0 --speed "$1"
}
# await_motion: the drives have answered "operation enabled" from more than three different positions.
await_motion() {
  local i
  for ((i = 0; i < 300 * patience; ++i)); do
    [[ $(sed -n 's/.* 181#3712\(........\).*/\1/p' "$work/bus.log" | sort -u | wc -l) -gt 3 ]] && return 0
    kill -0 "${pid[host]}" 2>/dev/null || break
    sleep 0.1
  done
  fail "the arm does not move: $(tail -n 2 "$work/host.err")"
}
# last_status NODE: the state bits of the drive's last answer; statusword is little-endian.
last_status() {
  local word
  word=$(sed -n "s/.* 18$1#\(..\)\(..\).*/\2\1/p" "$work/bus.log" | tail -n 1)
  printf '%02x' $((0x$word & 0x6F))
}
