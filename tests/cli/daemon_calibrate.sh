#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A calibration made by HTTP alone, on a box that a daemon owns: dark, flat, in use, a run that is developed with it; and what is refused.
. "$(dirname "$0")/cli.bash"
. "$(dirname "$0")/server.bash"
. "$(dirname "$0")/daemon.bash"
[ -n "${DAEMON:-}" ] || exit 77 # built without a box

printf 'board: %s\ndata: data\nretry: 300ms\nlisten: ["127.0.0.1:0"]\n' "$SOURCE/boards/sim-small/board.yaml" >ttfboxd.yaml
lamps='lamps.left.warm_up: 500ms, lamps.right.warm_up: 500ms, lamps.left.interlock: none, lamps.right.interlock: none'
printf 'set: {lock: %s/box.lock, sim.clock: real, sim.scene.name: white, sim.sensor.width: 96px, sim.sensor.height: 64px, %s}\n' "$WORK" "$lamps" >>ttfboxd.yaml

start() {
    : >log
    begin_daemon
    daemon_url
    ME=(-H "Authorization: Bearer $(cat data/.ttfbox/token)" -H 'Content-Type: application/json')
}
send() { # METHOD PATH STATUS JSON
    get "$URL/$2" "$3" "${ME[@]}" -X "$1" --data-binary "$4"
}
step() { # STATE: what the last step comes to, within a minute
    for _ in $(seq 600); do
        get "$URL/calibrations" 200 "${ME[@]}"
        case $(json step.state) in "$1") return 0 ;; done | refused) break ;; esac
        sleep 0.1
    done
    fail "the step: $(cat out); $(cat log)"
}
ask_status() { get "$URL/status" 200 "${ME[@]}"; }
ended() { # DATASET: it is sealed, and the box rests (it may do so still just after a run was asked for)
    for _ in $(seq 1200); do
        [ -e "data/$1/SHA256SUMS" ] && break
        sleep 0.05
    done
    state idle
}
plan() { # NAME: of 3 slots, 100 ms
    printf 'interval: 500ms\ncount: 3\nlamps: {mode: continuous, settle: 500ms}\nshot: {lamps: {left: 100%%, right: 100%%}, exposure: 20ms}\nkeep: both\nreserve: 0B\n' >"$1.yaml"
    get "$URL/plans/$1" 200 "${ME[0]}" "${ME[1]}" -H 'Content-Type: application/yaml' -X PUT --data-binary "@$1.yaml"
}
quantity() { "$PYTHON" -c 'import json, sys; print(json.load(open(sys.argv[1]))["streams"][0]["quantity"])' "data/$1/dataset.json"; }

start
plan three
get "$URL/calibrations" 200 "${ME[@]}"
is calibrations '[]'
expect 1 "$TTFBOX" calibrate dark --board sim-small --set "lock=$WORK/box.lock" -o cal
said err "the page of a box that ttfboxd has makes the same"
send POST calibrations/first 400 '{"part":"tea"}'
send POST calibrations/first 400 '{"part":"geometry"}'
send POST calibrations/..%2fx 404 '{"part":"dark"}'
get "$URL/calibrations/first" 401 -H 'Content-Type: application/json' -X POST --data-binary '{"part":"dark"}'

send POST calibrations/first 400 '{"part":"flicker"}'
send POST calibrations/first 400 '{"part":"chart","corners":[[0,0],[9,0],[9,9],[0,9]]}'

# ---- dark and flat for a plan's shot; what is there is not overwritten ----
send POST calibrations/first 202 '{"part":"dark","plan":"three","frames":8}'
step 'done'
is calibrations.0.name first
is calibrations.0.dark.frames 8
is calibrations.0.dark.exposure_ns 20000000
send POST calibrations/first 409 '{"part":"dark","plan":"three","frames":8}'
send POST calibrations/first 202 '{"part":"flat","plan":"three","frames":8}'
step 'done'
is calibrations.0.flat.frames 8
send POST calibrations/first 202 '{"part":"flicker","plan":"three","frames":16}'
step 'done'
is calibrations.0.flicker.frames 16
expect 0 "$TTFBOX" calibrate report data/.ttfbox/calibrations/first
grep -q SIMULATED out || fail "a simulated calibration does not say so"

# ---- what cannot be right is refused with why, and leaves nothing ----
send POST calibrations/bright 202 '{"part":"flat","exposure_ns":900000000,"frames":2}'
step refused
[ -n "$(json step.error)" ] || fail "it does not say why"
[ ! -e data/.ttfbox/calibrations/bright ] || fail "it left something"
send POST calibrations/lost 202 '{"part":"dark","plan":"none-such"}'
step refused

# ---- used from the next run on ----
send POST run 202 '{"plan":"three","dataset":"before"}'
ended before
[ "$(quantity before)" = radiance ] || fail "a run had a calibration that nobody chose"
send PUT calibration 404 '{"name":"none-such"}'
send PUT calibration 200 '{"name":"first"}'
send POST run 202 '{"plan":"three","dataset":"after"}'
ended after
[ "$(quantity after)" = reflectance ] || fail "the calibration that was chosen is not used: $(cat log)"
expect 0 "$TTFBOX" verify data/after

# ---- one that is chosen and cannot be read is not left out without a word ----
mv data/.ttfbox/calibrations/first moved
send POST run 202 '{"plan":"three","dataset":"later"}'
state retrying
grep -q "first: the calibration that was chosen cannot be read" out || fail "it does not say which: $(cat out)"
mv moved data/.ttfbox/calibrations/first
ended later
[ "$(quantity later)" = reflectance ] || fail "the calibration that came back is not used: $(cat log)"

# ---- a run that was begun without one stays without, whatever is chosen meanwhile ----
sed 's/count: 3/count: 2000/' three.yaml >long.yaml
get "$URL/plans/long" 200 "${ME[0]}" "${ME[1]}" -H 'Content-Type: application/yaml' -X PUT --data-binary @long.yaml
send PUT calibration 200 '{"name":""}'
send POST run 202 '{"plan":"long","dataset":"bare"}'
state capturing
send PUT calibration 200 '{"name":"first"}'
kill -9 "$daemon"
wait "$daemon"
start
state capturing
[ "$(quantity bare)" = radiance ] || fail "a run without a calibration is $(quantity bare)"
[ ! -e data/bare/calibration ] || fail "a run that was gone on with got a calibration"
send POST run/stop 202 ''
state stopped

# ---- a run has the devices; one that is gone on with keeps its own; a run ends a step ----
send POST run 202 '{"plan":"long"}'
state capturing
send POST calibrations/second 409 '{"part":"dark","plan":"three"}'
grep -q 'a run has the devices' out || fail "it does not say why: $(cat out)"
send POST run/stop 202 ''
state stopped
send PUT calibration 200 '{"name":""}'
send POST calibrations/second 202 '{"part":"dark","exposure_ns":400000000,"frames":400}'
step under-way
send POST calibrations/third 409 '{"part":"dark"}'
send POST run 202 '{}'
state capturing
step refused
grep -q 'a run wants the devices' out || fail "the step does not say what ended it: $(cat out)"
[ "$(quantity long)" = reflectance ] || fail "a run that was gone on with changed its calibration"
send POST run/stop 202 ''
state stopped

# ---- one that nothing needs is taken away; what is needed stays ----
remove() { # NAME STATUS
    get "$URL/calibrations/$1" "$2" "${ME[0]}" "${ME[1]}" -X DELETE
}
mine=data/.ttfbox/calibrations
remove none-such 404
get "$URL/calibrations/first" 401 -X DELETE
send POST calibrations/spare 202 '{"part":"dark","plan":"three","frames":2}'
step 'done'
send PUT calibration 200 '{"name":"spare"}'
remove spare 409
grep -q 'is in use' out || fail "it does not say why: $(cat out)"
send POST run 202 '{"plan":"long","dataset":"holds"}'
state capturing
send PUT calibration 200 '{"name":"first"}'
remove spare 409
grep -q 'a run under way is developed with it' out || fail "it does not say why: $(cat out)"
send POST run/stop 202 ''
state stopped
send POST calibrations/made 202 '{"part":"dark","exposure_ns":400000000,"frames":400}'
step under-way
remove made 409
grep -q 'is being made' out || fail "it does not say why: $(cat out)"
mkdir "$mine/.spare.removed" && echo half >"$mine/.spare.removed/flat.tif" # of a removal that was cut off
remove spare 200
[ -z "$(find "$mine" -name '*spare*')" ] || fail "something of it is left: $(find "$mine")"
get "$URL/calibrations" 200 "${ME[@]}"
grep -q '"name":"first"' out || fail "another one is gone: $(cat out)"
! grep -q '"name":"spare"' out || fail "it is still listed: $(cat out)"
remove spare 404

# ---- the end of the program does not wait for a step ----
step under-way
kill -TERM "$daemon"
timeout 30 tail --pid="$daemon" -f /dev/null || fail "it does not end: $(cat log)"
wait "$daemon" || fail "it ended with $?: $(cat log)"
[ ! -e "$mine/made" ] || fail "a step that was not done left something"

# ---- what a removal left that was cut off is gone at the next start; the configured one stays ----
mkdir "$mine/.old.removed" && cp "$mine"/first/* "$mine/.old.removed"
printf 'calibration: data/.ttfbox/calibrations/first\n' >>ttfboxd.yaml
start
get "$URL/calibrations" 200 "${ME[@]}"
[ ! -e "$mine/.old.removed" ] || fail "what was taken away is still there"
send PUT calibration 200 '{"name":""}'
remove first 409
grep -q 'configuration names' out || fail "it does not say why: $(cat out)"
kill -TERM "$daemon"
wait "$daemon"

# ---- nor is a run that waits for something held up by a step ----
printf 'plan: late.yaml\ndataset: late\n' >>ttfboxd.yaml
start
state waiting
send POST calibrations/second 409 '{"part":"dark","exposure_ns":400000000,"frames":1000}'
cp three.yaml late.yaml
ended late
