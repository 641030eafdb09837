#!/usr/bin/env bash
# The man page explains the flags that --help lists, no more and no less.
# Usage: man_page.sh PROGRAM PAGE
set -uo pipefail

flags() { grep -o -- '--[a-z][a-z-]*' | sort -u; }
in_help=$("$1" --help | flags)
in_page=$(sed -n '/^\.SH OPTIONS/,/^\.SH FILES/p' "$2" | sed 's/\\-/-/g' | grep '^\.BI* ' | flags)
[[ -n $in_help ]] || { echo "$1 --help names no flag"; exit 1; }
different=$(diff <(echo "$in_help") <(echo "$in_page")) || { echo "$2: not the flags of --help (<):"; echo "$different"; exit 1; }
