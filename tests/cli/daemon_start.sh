#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ttfboxd and a plan with a start: it waits for it and says so; a box that does not know what time it is says that, and waits for whoever knows.
. "$(dirname "$0")/cli.bash"
. "$(dirname "$0")/bench.bash"
. "$(dirname "$0")/daemon.bash"
[ -n "${DAEMON:-}" ] || exit 77 # built without a box

bench_box
printf 'board: ./box.yaml\ndata: data\nretry: 300ms\nlisten: [unix:http]\n' >ttfboxd.yaml

start() {
    : >log
    begin_daemon
    heard listening
}
asked() { # STATUS PATH [curl's options]
    local got
    got=$(curl -sS --unix-socket http -H "Authorization: Bearer $(cat data/.ttfbox/token)" -o out -w '%{http_code}' "${@:3}" "http://localhost/api/v1/$2")
    [ "$got" = "$1" ] || fail "$2 is answered with $got instead of $1: $(cat out)"
}
AS_JSON=(-H 'Content-Type: application/json' -d)
ask_status() { asked 200 status; }
in_future() { date -u -d "+$1 seconds" +%Y-%m-%dT%H:%M:%SZ; }
tell_time() { asked 200 time "${AS_JSON[@]}" "{\"utc_ns\":$(date +%s%N)}"; }
starting() { # NAME SECONDS LINE...: a plan that starts so much later
    plan "$1.yaml" 'interval: 1s' "start: $(in_future "$2")" 'shot: {exposure: 10ms}' 'keep: raw' 'reserve: 0B' "${@:3}"
}

mkdir data
start
asked 200 status
trust=$(json time.trust)
if [ "$trust" = none ]; then
    # ---- nobody vouches for the clock: checked, it is said; put in its place, it is taken; it cannot be started ----
    starting later 3600 'count: 5'
    asked 200 plans/check -H 'Content-Type: application/yaml' --data-binary @later.yaml
    is ok true
    is findings.0.level warning
    said out "nobody vouches for the box's clock"
    asked 200 plans/later -X PUT -H 'Content-Type: application/yaml' --data-binary @later.yaml
    asked 409 run "${AS_JSON[@]}" '{"plan":"later"}'
    said out "nobody vouches for the box's clock"
    said out "by a PC"
    state idle
    end_daemon

    # ---- the configuration's waits, and says for what; the clock is set when its start has passed: the slots of that time are lost, and no others ----
    starting grass 2 'count: 9'
    sed -i 's/^data/plan: grass.yaml\ndata/' ttfboxd.yaml
    start
    state waiting
    json why | grep -q "nobody vouches for the box's clock" || fail "it does not say for what: $(json why)"
    heard '<4>waiting for=clock dataset="grass"'
    sleep 3
    state waiting
    [ ! -e data/grass ] || fail "a dataset was begun"
    tell_time
    is taken true
    state capturing
    heard '<5>done slots=9'
    "$PYTHON" - data/grass/records.jsonl <<'END' || fail "not the slots of before it"
import json, sys
slots = [r for r in map(json.loads, open(sys.argv[1], encoding="utf-8")) if r["type"] == "slot"]
lost = [r for r in slots if r["result"] != "captured"]
assert 1 <= len(lost) <= 8 and slots[: len(lost)] == lost, slots
assert {r.get("reason") for r in lost} == {"the capture began after this slot"}, lost
END
    end_daemon
    sed -i '/^plan/d' ttfboxd.yaml
    rm -rf data
    mkdir data
    start
    tell_time
fi

# ---- until a start that is to come it waits, and can be stopped; then it captures ----
starting soon 3600 'count: 3'
asked 200 plans/soon -X PUT -H 'Content-Type: application/yaml' --data-binary @soon.yaml
asked 202 run "${AS_JSON[@]}" '{"plan":"soon","dataset":"never"}'
state waiting
is run.next.index 0
[ "$(json run.next.in_ns)" -gt 3000000000000 ] || fail "it does not say when"
asked 202 run/stop -X POST
state stopped
starting soon 8 'count: 3'
asked 200 plans/soon -X PUT -H 'Content-Type: application/yaml' --data-binary @soon.yaml
asked 202 run "${AS_JSON[@]}" '{"plan":"soon"}'
state waiting
heard '<6>armed next=0'
asked 200 status
is state waiting
state capturing
heard '<5>done slots=3 captured=3'

# ---- with another stream it begins another dataset, of the same group ----
plan infrared.yaml 'interval: 1s' 'count: 2' 'shot: {stream: infrared, exposure: 10ms}' 'keep: raw' 'reserve: 0B' 'group: nowhere'
asked 200 plans/infrared -X PUT -H 'Content-Type: application/yaml' --data-binary @infrared.yaml
asked 400 run "${AS_JSON[@]}" '{"plan":"infrared"}'
said out "there is no dataset 'nowhere' on this box"
sed -i 's/nowhere/soon/' infrared.yaml
asked 200 plans/infrared -X PUT -H 'Content-Type: application/yaml' --data-binary @infrared.yaml
asked 202 run "${AS_JSON[@]}" '{"plan":"infrared"}'
heard '<5>done slots=2 captured=2'
expect 0 "$TTFBOX" info data/soon --json
OF=$(json uuid)
expect 0 "$TTFBOX" info data/infrared --json
is group_uuid "$OF"
end_daemon
expect 0 "$TTFBOX" verify data/soon
