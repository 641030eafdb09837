#!/usr/bin/env bash
# The Debian package of the controller that was built for ARM computers: made by CPack, of that architecture, whole; its
# program is small, needs the C library only, and starts in the emulator with the robot file that came with it.
# Usage: arm64_package.sh TREE EMULATOR...
set -euo pipefail
tree=$1; shift
[[ $# -gt 0 ]] || { echo "no emulator (package qemu-user)"; exit 1; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
(cd "$work" && cpack -G DEB --config "$tree/CPackConfig.cmake" -B "$work") >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
package=$(echo "$work"/armsight-controller_*_arm64.deb)
[[ -f $package ]] || { echo "CPack made no armsight-controller_VERSION_arm64.deb:"; cat "$work/log"; exit 1; }

expect() { [[ $2 =~ $3 ]] || { echo "$1 of the package: '$2', must match $3"; exit 1; }; }
expect Architecture "$(dpkg-deb -f "$package" Architecture)" '^arm64$'
expect Depends "$(dpkg-deb -f "$package" Depends)" '^libc6 \(>= [0-9.]+\)$'
expect conffiles "$(dpkg-deb -I "$package" conffiles)" '^/etc/armsight/arm.yaml$'
dpkg-deb -x "$package" "$work/unpacked"
for file in usr/bin/arm_controller etc/armsight/arm.yaml usr/share/man/man8/arm_controller.8 \
  lib/systemd/system/armsight-controller@.service lib/udev/rules.d/60-armsight-controller.rules \
  usr/lib/sysusers.d/armsight-controller.conf usr/share/armsight-controller/network/80-can0.network; do
  [[ -s $work/unpacked/$file ]] || { echo "the package lacks $file"; exit 1; }
done

program=$work/unpacked/usr/bin/arm_controller
expect Machine "$(LC_ALL=C readelf -h "$program" | sed -n 's/^ *Machine: *//p')" '^AArch64$'
needed=$(readelf -d "$program" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | sort | tr '\n' ' ')
expect "needed libraries" "$needed" '^(ld-linux-aarch64\.so\.1 )?libc\.so\.6 libm\.so\.6 $'
bytes=$(stat -c %s "$program")
[[ $bytes -le 2500000 ]] || { echo "the program has $bytes bytes, more than 2.5 MB"; exit 1; }

help=$("$@" "$program" --help) || { echo "the program does not start in $1"; exit 1; }
expect "--help" "$help" '--require-rt'
code=0
said=$("$@" "$program" --config "$work/unpacked/etc/armsight/arm.yaml" --listen 127.0.0.1:0 --state "$work/state" \
  --bus "emulated:$work/no-bus" 2>&1) || code=$?
[[ $code -eq 3 ]] || { echo "without a bus the program ends with $code instead of 3:"; echo "$said"; exit 1; }
echo "$(basename "$package"): $bytes bytes of program; $(tail -n 1 <<<"$said")"
