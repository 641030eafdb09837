#!/bin/sh
# messages.sh PROTOC SOURCE_ROOT [--update]: every message of messages.txt still becomes the bytes written there. A failure
# means that a field's number or type changed: old peers and recordings would be misread. Numbers are never reused
# (protocol/README.md); a new field gets a new line.
set -eu
protoc=$1 root=$2 update=${3:-}
golden=$root/tests/protocol/golden/messages.txt
cd "$root"

failed=0 count=0 all=
while IFS='|' read -r type hex text; do
  line="$type"
  case $type in '#'*) line="$type|$hex|$text" ;; *)
    count=$((count + 1))
    now=$(echo "$text" | "$protoc" -I . --encode="armsight.wire.$type" protocol/arm_link.proto \
      protocol/camera_stream.proto protocol/sim_clock.proto protocol/recording.proto | od -An -v -tx1 | tr -d ' \n')
    line="$type|$now|$text"
    if [ "$update" != --update ] && [ "$now" != "$hex" ]; then
      printf '%s: %s\n  golden %s\n  now    %s\n' "$type" "$text" "$hex" "$now"
      failed=1
    fi ;;
  esac
  all="$all$line
"
done <"$golden"
if [ "$update" = --update ]; then printf '%s' "$all" >"$golden"; fi
[ "$failed" = 0 ] && echo "golden messages: $count unchanged"
exit "$failed"
