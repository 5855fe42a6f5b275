#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The settings that an image comes with, as the daemon reads them; and who may read a copy of settings with a token in it.
. "$(dirname "$0")/cli.bash"
[ -n "${DAEMON:-}" ] || exit 77 # built without a box
image=$SOURCE/firmware/image

mkdir stage
sed 's/@BOARD@/qemu-virt-arm64/' "$image/settings/ttfbox.yaml" >stage/ttfboxd.yaml
plan stage/plan.yaml 'interval: 10min' 'until: 7d' 'lamps: {mode: capture-only, settle: 2s}' 'shots: [{lamps: {left: 100%, right: 100%}, exposure: 20ms}]'
expect 0 env -C "$SOURCE" "$DAEMON" --check --config "$WORK/stage/ttfboxd.yaml"
# This machine, the cable's streams, the cable's network; and the builder leaves the line out where there is no cable.
grep -q '^listen: \["127.0.0.1:8417", "unix:/run/ttfbox/http.sock", "usb0:8417"\]' stage/ttfboxd.yaml || fail "an image listens elsewhere"
grep -q 'listen=/^listen:/d' "$image/build.sh" || fail "the builder leaves it in"

# --- a token of one's own: as the card's file system and a PC's editor leave it
# The # alone is taken away, as README.txt says; of each line that has one.
for key in token_file dataset calibration; do
    grep -q "^#$key:" stage/ttfboxd.yaml || fail "the settings that an image comes with do not name $key"
done
sed -i 's/^#token_file:/token_file:/; s/^#dataset:/dataset:/' stage/ttfboxd.yaml
printf 'too-short\r\n' >stage/token
mkdir -p stage/boards/mine
touch stage/boards/mine/board.yaml
chmod -R go= stage
owner=$(id -u)
[ "$owner" != 0 ] || owner=65534
expect 0 sh "$image/root/usr/lib/ttfbox/settings-modes" stage "$owner"
[ "$(stat -c '%a %u' stage/token)" = "600 $owner" ] || fail "the token is $(stat -c '%a %u' stage/token)"
[ "$(stat -c %A stage stage/plan.yaml stage/boards/mine stage/boards/mine/board.yaml | cut -c5,8 | sort -u)" = rr ] ||
    fail "not all that is no token can be read: $(ls -lR stage)"
chown "$(id -u)" stage/token
expect 2 env -C "$SOURCE" "$DAEMON" --check --config "$WORK/stage/ttfboxd.yaml"
said err 'stage/token: holds no token'
printf '\r\n' >stage/token
expect 2 env -C "$SOURCE" "$DAEMON" --check --config "$WORK/stage/ttfboxd.yaml"
printf '0123456789abcdef\r\n' >stage/token
expect 0 env -C "$SOURCE" "$DAEMON" --check --config "$WORK/stage/ttfboxd.yaml"
chmod 644 stage/token
env -C "$SOURCE" "$DAEMON" --check --config "$WORK/stage/ttfboxd.yaml" 2>err && fail "a token that others may read is taken"
said err 'others may read the token in it'

# --- without one nothing is missed
rm stage/token
expect 0 sh "$image/root/usr/lib/ttfbox/settings-modes" stage "$owner"
expect 0 env -C "$SOURCE" "$DAEMON" --check --config "$WORK/stage/ttfboxd.yaml"
