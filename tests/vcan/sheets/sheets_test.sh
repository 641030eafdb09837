#!/usr/bin/env bash
# sheets_test.sh DUMP_WIRE SOURCE WORK PEERS: protocol/'s EDS and DBC, read by npm's canopen and python3-canmatrix, say what
# the code does. Needs no bus.
set -uo pipefail
dump_wire=$1 source=$2 work=$3 peers=$4
skip() {
  echo "sheets: $1"
  [[ ${ARMSIGHT_REQUIRE_VCAN:-0} == 1 ]] && exit 1
  echo "SKIPPED: set ARMSIGHT_REQUIRE_VCAN=1 to make this a failure"
  exit 77
}
[[ -f $peers/installed ]] || skip "the peers are not installed (tests/vcan/peers/install build/peers)"
# The system's own interpreter: Debian's package is in its path, not in that of a Python from elsewhere.
/usr/bin/python3 -c 'import canmatrix' 2>/dev/null || skip "python3-canmatrix is missing"
mkdir -p "$work"
"$dump_wire" >"$work/wire.txt" || exit 1
here=$source/tests/vcan/sheets
node "$here/check_eds.js" "$peers" "$source/protocol/armsight_drive.eds" "$work/wire.txt" || exit 1
/usr/bin/python3 "$here/check_dbc.py" "$source/protocol/arm.dbc" "$work/wire.txt" 2>"$work/canmatrix.err" || { tail -n 3 "$work/canmatrix.err"; exit 1; }
