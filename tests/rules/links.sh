#!/usr/bin/env bash
# arm_controller links only what an arm computer has: neither OpenCV nor Ceres, nor anything else unforeseen.
# Usage: links.sh PROGRAM
set -euo pipefail

allowed='^(libprotobuf-lite|libyaml-cpp|libz|libzstd|libm|libc|libstdc\+\+|libgcc_s|libpthread|ld-linux.*|libasan|libubsan|libtsan)\.so'
needed=$(objdump -p "$1" | sed -n 's/^ *NEEDED *//p')
[[ -n $needed ]] || { echo "objdump tells of no NEEDED library of $1"; exit 1; }
if extra=$(grep -vE "$allowed" <<<"$needed"); then
  printf '%s needs what no arm computer is asked to have:\n%s\n' "$1" "$extra"
  exit 1
fi
