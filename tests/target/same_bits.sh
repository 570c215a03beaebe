#!/usr/bin/env bash
# usage: same_bits.sh REPLAY_HOST COMMAND...: the host's replay and the image that COMMAND runs give the
# same digest, with the recorded counts and with one bit of them flipped; and the flipped bit is seen.
set -eu -o pipefail
host=$1
shift
code=0
ours=$("$host" digest)
theirs=$("$@") || code=$?
[ $code = 0 ] || { echo "$theirs"; exit $code; }
ours_flipped=$("$host" digest flip)
theirs_flipped=$("$@" flip)
echo "host  $ours, with one input bit flipped $ours_flipped"
echo "image $theirs, with one input bit flipped $theirs_flipped"
same() { [ -n "$1" ] && [ "$1" = "$2" ]; }
same "$ours" "$theirs" || { echo "host and image differ"; exit 1; }
same "$ours_flipped" "$theirs_flipped" || { echo "host and image differ after a flipped bit"; exit 1; }
if same "$ours" "$theirs_flipped"; then
    echo "one flipped bit goes unnoticed: the digest does not cover the run"
    exit 1
fi
