#!/usr/bin/env bash
# A program answers --help with exit code 0 and refuses an unknown flag with exit code 2, naming it.
# Usage: program.sh PROGRAM
set -uo pipefail

text=$("$1" --help 2>&1); code=$?
[[ $code -eq 0 && -n $text ]] || { echo "$1 --help: exit code $code, $(wc -l <<<"$text") lines; must be 0 and not silent"; exit 1; }
text=$("$1" --no-such-flag 2>&1 </dev/null); code=$?
[[ $code -eq 2 ]] || { echo "$1 --no-such-flag: exit code $code; must be 2"; exit 1; }
grep -q 'no-such-flag' <<<"$text" || { echo "$1 --no-such-flag: the message does not name the flag:"; echo "$text"; exit 1; }
