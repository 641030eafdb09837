#!/usr/bin/env bash
# arm_controller is small and asks the arm computer for nothing but its C library (and OpenSSL): 2.5 MB, neither OpenCV
# nor Ceres, none of our libraries that Debian would have to bring. Sanitizers bring theirs, and are large.
# Usage: links.sh PROGRAM
set -euo pipefail

needed=$(objdump -p "$1" | sed -n 's/^ *NEEDED *//p')
[[ -n $needed ]] || { echo "objdump tells of no NEEDED library of $1"; exit 1; }
allowed='^(libssl|libcrypto|libm|libc|ld-linux.*)\.so'
most_bytes=2500000
if grep -qE '^lib(asan|ubsan|tsan)\.' <<<"$needed"; then
  allowed='^(libssl|libcrypto|libm|libc|ld-linux.*|libasan|libubsan|libtsan|libstdc\+\+|libgcc_s|libz)\.so'
  most_bytes=100000000
fi
if extra=$(grep -vE "$allowed" <<<"$needed"); then
  printf '%s needs what no arm computer is asked to have:\n%s\n' "$1" "$extra"
  exit 1
fi
stripped=$(mktemp)
trap 'rm -f "$stripped"' EXIT
strip -o "$stripped" "$1"
bytes=$(stat -c %s "$stripped")
[[ $bytes -le $most_bytes ]] || { echo "$1 has $bytes bytes when stripped, more than $most_bytes"; exit 1; }
echo "$1: $bytes bytes when stripped; needs" $needed
