#!/usr/bin/env bash
# The controller's systemd unit is sound and locked in: systemd-analyze finds nothing to say and an exposure of at most 3.
# Usage: unit.sh REPOSITORY
set -euo pipefail

command -v systemd-analyze >/dev/null || { echo "SKIP: no systemd-analyze (package systemd)"; exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
unit=$folder/armsight-controller@can0.service
# The program is not installed here, and its page neither.
sed -e 's|^ExecStart=/usr/bin/arm_controller .*|ExecStart=/bin/true|' -e '/^Documentation=/d' \
  "$1/arm_controller/package/armsight-controller@.service" >"$unit"
said=$(systemd-analyze verify "$unit" 2>&1) || { printf '%s\n' "$said"; exit 1; }
[[ -z $said ]] || { printf '%s\n' "$said"; exit 1; }
systemd-analyze security --offline=true --threshold=30 --no-pager "$unit" | tail -n 1
