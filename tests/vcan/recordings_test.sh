#!/usr/bin/env bash
# recordings_test.sh PROGRAMS SOURCE WORK RECORDED: what can_decode and candump wrote of the same traffic (by
# peers_test.sh in RECORDED) is the same; log2asc reads ours, we read candump's, canplayer puts ours on a bus again.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
needs_vcan
recorded=$4
[[ -s $recorded/can_decode.log && -s $recorded/candump.log ]] || skip "peers_test left no recording"
rm -rf "$work"
mkdir -p "$work"
frames_of() { sed 's/^([0-9.]*) [^ ]* //' "$1"; }

frames_of "$recorded/candump.log" >"$work/theirs.txt"
frames_of "$recorded/can_decode.log" >"$work/ours.txt"
diff "$work/theirs.txt" "$work/ours.txt" >"$work/diff.txt" || { head -n 5 "$work/diff.txt"; fail "candump and can_decode differ (< candump's)"; }
frames=$(wc -l <"$work/ours.txt")

"$programs/read_candump" <"$recorded/candump.log" >"$work/read.log" || fail "our reader refuses candump's text"
diff "$recorded/candump.log" "$work/read.log" >"$work/diff.txt" || { head -n 5 "$work/diff.txt"; fail "our reader changes candump's text"; }

log2asc -I "$recorded/can_decode.log" -O "$work/ours.asc" vcan0 || fail "log2asc refuses ours"
[[ $(grep -c ' Rx ' "$work/ours.asc") == "$frames" ]] || fail "log2asc read $(grep -c ' Rx ' "$work/ours.asc") of $frames frames"

head -n 500 "$recorded/can_decode.log" >"$work/played.log"
begin again "$programs/can_decode" --can vcan1
begin witness candump -L vcan1
sleep "$patience"
canplayer -g 5 -I "$work/played.log" vcan1=vcan0 || fail "canplayer refuses ours"
sleep 1
end again || fail "can_decode ended with $?"
end witness INT
for log in again witness; do
  diff <(head -n 500 "$work/ours.txt") <(frames_of "$work/$log.log") >"$work/diff.txt" || { head -n 5 "$work/diff.txt"; fail "$log saw other frames than were played (< played)"; }
done
echo "$test_name: $frames frames the same in candump's and our text, 500 played again"
