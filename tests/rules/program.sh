#!/usr/bin/env bash
# A program answers --help with exit code 0 and refuses an unknown flag with exit code 2 and a reason.
# Usage: program.sh PROGRAM
set -uo pipefail

text=$("$1" --help 2>&1); code=$?
[[ $code -eq 0 && -n $text ]] || { echo "$1 --help: exit code $code, $(wc -l <<<"$text") lines; must be 0 and not silent"; exit 1; }
text=$("$1" --no-such-flag 2>&1 </dev/null); code=$?
[[ $code -eq 2 ]] || { echo "$1 --no-such-flag: exit code $code; must be 2"; exit 1; }
grep -Eq 'no-such-flag|required' <<<"$text" || { echo "$1 --no-such-flag: the message names neither the flag nor what is missing:"; echo "$text"; exit 1; }
