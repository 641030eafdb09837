#!/usr/bin/env bash
# faults_test.sh PROGRAMS SOURCE WORK: error frames and lost frames on a real CAN socket while the arm moves. The verdict is
# read from the log of the simulated drives (what they received and answered), never from the controller's report.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
needs_vcan
fresh_work

# A slow move is under way when the fault comes.
begin_arm vcan0
begin_controller
begin_move 0.1
await_motion

# Error passive: noticed, no reason to stop.
cansend vcan0 20000004#0020000000000000
sleep "$patience"
[[ $(last_status 1) == 27 ]] || fail "an error-passive frame took drive 1 out of operation ($(last_status 1))"

# Frames get lost: one in fifty is bridged.
tc qdisc add dev vcan0 root netem loss 2% || fail "tc cannot lose frames"
sleep "$((2 * patience))"
tc qdisc del dev vcan0 root
[[ $(last_status 1) == 27 ]] || fail "2 % of lost frames took drive 1 out of operation ($(last_status 1))"

# Bus-off: all drives stop at once and stay powered.
cansend vcan0 20000040#0000000000000000
sleep "$patience"
for node in 1 2 3 4 5 6; do
  [[ $(last_status "$node") == 07 ]] || fail "after bus-off drive $node is in state $(last_status "$node"), not in quick stop"
done
end host KILL
end arm_controller || fail "arm_controller ended with $?"
end arm_sim || fail "arm_sim ended with $?"
grep -q "fault 102" "$work/arm_controller.err" || fail "the controller did not name bus-off: $(<"$work/arm_controller.err")"

# An interface that is not there is an error, never another bus.
"$programs/arm_controller" --config "$work/robot.yaml" --listen 127.0.0.1:0 --state "$work/controller" --can nosuch0 >"$work/missing.txt" 2>&1
code=$?
[[ $code == 3 ]] || fail "a missing interface ended with $code: $(<"$work/missing.txt")"
grep -q "nosuch0" "$work/missing.txt" || fail "the interface is not named: $(<"$work/missing.txt")"
echo "$test_name: error passive and 2 % loss carried, bus-off stopped six drives, a missing interface is refused"
