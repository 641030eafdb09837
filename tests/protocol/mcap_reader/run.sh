#!/bin/sh
# run.sh WRITE_SAMPLES WORK_FOLDER: our recording through MCAP's own reader; then with one bit flipped, which it must refuse.
# Exit 77 (skipped) where npm's packages cannot be had, unless ARMSIGHT_REQUIRE_PEERS=1.
set -eu
write_samples=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)

skip() {
  echo "mcap_reader: $1"
  [ "${ARMSIGHT_REQUIRE_PEERS:-0}" = 1 ] && exit 1
  echo "SKIPPED: set ARMSIGHT_REQUIRE_PEERS=1 to make this a failure"
  exit 77
}

command -v node >/dev/null || skip "node is missing (apt-get install nodejs npm)"
command -v npm >/dev/null || skip "npm is missing (apt-get install nodejs npm)"
mkdir -p "$work"
cp "$here/package.json" "$here/package-lock.json" "$here/read_mcap.mjs" "$here/check_sample.mjs" "$work/"
cd "$work"
if ! cmp -s package-lock.json installed-lock.json; then
  npm ci --ignore-scripts --no-audit --no-fund >npm.log 2>&1 ||
    { tail -n 3 npm.log; skip "npm cannot fetch the packages of package-lock.json"; }
  cp package-lock.json installed-lock.json
fi

"$write_samples" "$work"
node read_mcap.mjs sample.mcap >found.json
node check_sample.mjs found.json
for damaged in flipped-chunk.mcap flipped-summary.mcap; do
  if node read_mcap.mjs "$damaged" >/dev/null 2>refused.txt; then
    echo "mcap_reader: $damaged was taken although a bit is flipped"
    exit 1
  fi
  cat refused.txt
done
