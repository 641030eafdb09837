#!/bin/sh
# candump_readers.sh WRITE_SAMPLES WORK_FOLDER: log2asc and Wireshark read our candump text, no frame malformed.
# Exit 77 (skipped) where they are missing, unless ARMSIGHT_REQUIRE_PEERS=1.
set -eu
write_samples=$1 work=$2

skip() {
  echo "candump_readers: $1"
  [ "${ARMSIGHT_REQUIRE_PEERS:-0}" = 1 ] && exit 1
  echo "SKIPPED: set ARMSIGHT_REQUIRE_PEERS=1 to make this a failure"
  exit 77
}
fail() { echo "candump_readers: $1"; exit 1; }

command -v log2asc >/dev/null || skip "log2asc is missing (apt-get install can-utils)"
command -v tshark >/dev/null || skip "tshark is missing (apt-get install tshark)"
mkdir -p "$work"
cd "$work"
"$write_samples" "$work"
frames=$(wc -l <traffic.log)

log2asc -I traffic.log -O traffic.asc can0
[ "$(grep -c ' Rx ' traffic.asc)" = "$frames" ] || fail "log2asc read $(grep -c ' Rx ' traffic.asc) of $frames frames"

tshark -r traffic.log -d can.subdissector,canopen -V >traffic.txt 2>tshark.err || { cat tshark.err; fail "tshark refuses the text"; }
[ "$(grep -c '^Frame ' traffic.txt)" = "$frames" ] || fail "tshark read $(grep -c '^Frame ' traffic.txt) of $frames frames"
if grep -in 'malformed\|expert info (error' traffic.txt; then fail "tshark calls a frame malformed"; fi
# What CANopen's dissector calls each frame, in the order of write_samples.
cat >expected.txt <<'END'
NMT
SYNC
EMCY
PDO1 (tx)
PDO1 (rx)
Default-SDO (rx)
Default-SDO (tx)
Default-SDO (rx)
Default-SDO (tx)
Default-SDO (tx)
Default-SDO (rx)
NMT Error Control
NMT Error Control
END
sed -n 's/^    Type: //p' traffic.txt >seen.txt
diff expected.txt seen.txt || fail "tshark takes frames for something else (< expected, > seen)"
echo "candump_readers: $frames frames read by log2asc and tshark"
