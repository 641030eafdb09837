#!/usr/bin/env bash
# peers_test.sh PROGRAMS SOURCE WORK PEERS: six CiA 402 drives that are not ours, brought to operation enabled and moved
# by our controller over AF_CAN. The verdict is the drives'. Leaves the bus' recordings for recordings_test.sh.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
peers=$4
needs_vcan
[[ -f $peers/installed ]] || skip "the peers are not installed (tests/vcan/peers/install build/peers)"
fresh_work

begin candump candump -L vcan0
begin can_decode "$programs/can_decode" --can vcan0
begin six_drives node "$source/tests/vcan/peers/six_drives.js" "$peers" "$source/protocol/armsight_drive.eds" vcan0
await six_drives "six_drives: ready"
begin_controller
host move --joints=0.30,0.20,-0.20,0.50,0.40 || fail "the host's move ended with $?: $(<"$work/arm_controller.err")"
end arm_controller || fail "arm_controller ended with $?"
end six_drives || fail "six_drives ended with $?"
sleep 1
end candump INT
end can_decode || fail "can_decode ended with $?"
node "$source/tests/vcan/peers/check_drives.js" "$work/six_drives.log" 0.30 0.20 -0.20 0.50 0.40 || exit 1

# A third opinion on every byte.
tshark -r "$work/candump.log" -d can.subdissector,canopen -V >"$work/tshark.txt" 2>"$work/tshark.err" || fail "tshark: $(<"$work/tshark.err")"
frames=$(wc -l <"$work/candump.log")
[[ $(grep -c '^Frame ' "$work/tshark.txt") == "$frames" ]] || fail "tshark read $(grep -c '^Frame ' "$work/tshark.txt") of $frames frames"
if grep -in 'malformed\|expert info (error' "$work/tshark.txt"; then fail "tshark calls a frame malformed"; fi
echo "$test_name: $frames frames on the bus, none malformed for tshark"
