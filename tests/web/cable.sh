#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The page of a simulated box over its simulated cable, in a browser: how a person gets the token.
. "$(dirname "$0")/../cli/cli.bash"
. "$(dirname "$0")/../cli/bench.bash"
: "${DAEMON:?}" "${USBD:?}" "${CABLE:?the simulated cable}"

bench_box
printf 'board: ./box.yaml\ndata: data\nlisten: ["unix:http"]\n' >ttfboxd.yaml
there() { # NAME: within 20 s
    for _ in $(seq 400); do
        [ -e "$1" ] && return 0
        sleep 0.05
    done
    fail "there is no $1: $(cat log)"
}
{ "$DAEMON" --config ttfboxd.yaml & } >log 2>&1
there http
{ "$CABLE" "$WORK/cable" 1 & } >>log 2>&1
there cable.control
{ "$USBD" --cable "$WORK/cable" --server "$WORK/http" & } >>log 2>&1
{ "$TTFBOX" usb --box "cable:$WORK/cable" --listen 127.0.0.1:0 --json & } >where 2>>log
for _ in $(seq 400); do
    [ -s where ] && break
    sleep 0.05
done
node "$SOURCE/tests/web/cable.mjs" "http://$(sed 's/.*"listening":"\([^"]*\)".*/\1/' where)" data/.ttfbox/token || {
    tail -n 20 log >&2
    exit 1
}
