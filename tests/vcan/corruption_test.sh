#!/usr/bin/env bash
# corruption_test.sh PROGRAMS SOURCE WORK: a gateway of the kernel (cangw) between the controller on vcan0 and the drives
# on vcan1 changes one bit of one position, with a good checksum. The verdict is read from the log of the drives.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
needs_vcan
fresh_work

# Everything passes both ways; the samples of node 3 by a rule of their own.
cangw -F
trap 'cangw -F; end_all' EXIT
cangw -A -s vcan0 -d vcan1 -e && cangw -A -s vcan1 -d vcan0 -e -f 183~7FF && cangw -A -s vcan1 -d vcan0 -e -f 183:7FF ||
  fail "cangw cannot route"
begin_arm vcan1
begin_controller
begin_move 0.1
await_motion
sleep "$patience"
[[ $(last_status 1) == 27 ]] || fail "the gateway alone took drive 1 out of operation ($(last_status 1))"

# Half a turn more: bit 14 of the position.
cangw -A -s vcan1 -d vcan0 -e -f 183:7FF -m XOR:D:0.8.0000004000000000 || fail "cangw cannot change a bit"
cangw -D -s vcan1 -d vcan0 -e -f 183:7FF || fail "cangw cannot drop the rule that changes nothing"
sleep "$((2 * patience))"
for node in 1 2 3 4 5 6; do
  [[ $(last_status "$node") == 07 ]] || fail "drive $node is in state $(last_status "$node"), not in quick stop"
done
grep -q "fault 206" "$work/arm_controller.err" || fail "the controller did not name it: $(<"$work/arm_controller.err")"
end host KILL
end arm_controller || fail "arm_controller ended with $?"
end arm_sim || fail "arm_sim ended with $?"
echo "$test_name: a position changed by half a turn on its way stopped six drives"
