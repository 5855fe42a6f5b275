#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ttfboxd from boot to boot, in real time: a simulated camera, and where it says so a real guardian on wires in a file.
. "$(dirname "$0")/cli.bash"
. "$(dirname "$0")/bench.bash"
. "$(dirname "$0")/daemon.bash"
[ -n "${DAEMON:-}" ] || exit 77 # built without a box

# Its faults are of the sample's age: by the machine's clock the disk would be full at once after a restart.
bench_box 'watchdog: {backend: systemd}'
echo '  faults: [{kind: disk-full, at: 200s}]' >>box.yaml
cat >ttfboxd.yaml <<'END'
board: ./box.yaml
plan: grass.yaml
data: data
retry: 300ms
listen: []
END
plan grass.yaml 'interval: 400ms' 'count: 12' 'shot: {exposure: 10ms}' 'keep: raw' 'reserve: 0B'

ends() { # CODE: the daemon, within 20 s
    local got
    for _ in $(seq 400); do
        kill -0 "$daemon" 2>/dev/null || break
        sleep 0.05
    done
    kill -0 "$daemon" 2>/dev/null && fail "it does not end: $(cat log)"
    wait "$daemon"
    got=$?
    [ "$got" = "$1" ] || fail "it ended with $got instead of $1: $(cat log)"
}
whole() { # SLOTS: the dataset is sealed, each slot has its record, all are captured but for MISSED at most
    expect 0 "$TTFBOX" verify data/grass --json
    expect 0 "$TTFBOX" info data/grass --json
    is slots "$1"
}

# ---- what is refused, with its place ----
expect 2 "$DAEMON"
said err "--config is missing"
expect 0 "$DAEMON" --help
said out "SIGTERM"
expect 2 "$DAEMON" --config nowhere.yaml
said err "nowhere.yaml"
printf 'board: ./box.yaml\nplan: grass.yaml\ndata: data\nretyr: 5s\n' >bad.yaml
expect 2 "$DAEMON" --config bad.yaml
said err "<3>failed"
said err "bad.yaml:4:1"
said err "'retry'"
printf 'board: ./box.yaml\nplan: grass.yaml\n' >bad.yaml
expect 2 "$DAEMON" --config bad.yaml
said err "'data' is missing"
printf 'board: ./box.yaml\nplan: grass.yaml\ndata: data\nlisten: 8417\n' >bad.yaml
expect 2 "$DAEMON" --config bad.yaml
said err "bad.yaml:4:9"
for wrong in 127.0.0.1 8417 '127.0.0.1:70000' '1.2.3:80' 'unix:' 'a-name-that-is-too-long-for-one:80'; do
    printf 'board: ./box.yaml\nplan: grass.yaml\ndata: data\nlisten: ["%s"]\n' "$wrong" >bad.yaml
    expect 2 "$DAEMON" --config bad.yaml --check
    said err "bad.yaml: listen: '$wrong' is no address to listen on"
done
printf 'board: ./box.yaml\nplan: grass.yaml\ndata: data\nlisten: ["usb0:80", "usb0:80"]\n' >bad.yaml
expect 2 "$DAEMON" --config bad.yaml --check
said err "'usb0:80' is there twice"
printf 'board: ./box.yaml\nplan: grass.yaml\ndata: data\nset: {sim.sensor.width: 4px}\n' >bad.yaml
expect 2 "$DAEMON" --config bad.yaml
said err "--set sim.sensor.width"
printf 'board: %s\nplan: grass.yaml\ndata: data\n' "$SOURCE/boards/sim-small/board.yaml" >bad.yaml
expect 2 "$DAEMON" --config bad.yaml
said err "this clock is virtual"
printf 'board: ./box.yaml\nplan: wrong.yaml\ndata: data\n' >bad.yaml
plan wrong.yaml 'interval: 5' 'count: 3'
expect 2 "$DAEMON" --config bad.yaml --check
said err "wrong.yaml:1:11"
expect 0 "$DAEMON" --config ttfboxd.yaml --check

# ---- a whole run under a manager, which hears of it; then it waits to be told to end ----
"$PYTHON" "$HERE/manager.py" "$WORK/notify" "$WORK/manager" &
manager=$!
heard listening manager
begin_daemon NOTIFY_SOCKET="$WORK/notify" WATCHDOG_USEC=20000000
heard "<5>done slots=12"
heard "STATUS=SIMULATED, capturing: 12 of 12 slots" manager
heard " of 12 slots captured, sealed" manager
heard "READY=1 | WATCHDOG_USEC=0" manager
heard "WATCHDOG_USEC=20000000" manager # armed while it runs
heard "WATCHDOG=1" manager
grep -q STOPPING manager && fail "it stops too soon"
kill -TERM "$daemon"
ends 0
heard "STOPPING=1" manager
heard "<5>stopped"
grep -qE '^<[1-7]>[a-z]+ [a-z_]+=' log || fail "lines without a priority and keys: $(cat log)"
whole 12
is simulated true
# Told of before the first slot, and not a word of a limit before it is armed.
first=$(grep -m1 -oE "WATCHDOG_USEC=[0-9]+" manager)
[ "$first" = "WATCHDOG_USEC=0" ] || fail "the manager counts before the run: $first"
kill "$manager"
wait "$manager" 2>/dev/null

# ---- started again, there is nothing to do, and it says so ----
rm -f log
begin_daemon X=1
heard "<5>done slots=12"
kill -TERM "$daemon"
ends 0

# ---- told to end within a run, it ends within a slot; started again it goes on ----
rm -rf data log
begin_daemon X=1
heard "<6>armed next=0 slots=12"
sleep 1
kill -TERM "$daemon"
ends 0
heard "<5>cut slots="
"$TTFBOX" info data/grass --json >out
is sealed false
rm -f log
begin_daemon X=1
heard "<5>resuming"
heard "sealed=yes"
kill -TERM "$daemon"
ends 0
whole 12
grep -q "disk full" log && fail "the sample aged with the machine: $(cat log)"

# ---- who owns the box ----
rm -rf data log
plan grass.yaml 'interval: 400ms' 'count: 500' 'shot: {exposure: 10ms}' 'keep: raw' 'reserve: 0B'
begin_daemon X=1
heard "<6>armed"
expect 1 "$DAEMON" --config ttfboxd.yaml
said err "the box is owned by ttfboxd, process $daemon, into data/grass"
expect 1 "$TTFBOX" capture grass.yaml --board ./box.yaml -o other
said err "the box is owned by ttfboxd, process $daemon"
expect 1 "$TTFBOX" calibrate dark --plan grass.yaml --board ./box.yaml -o cal
said err "the box is owned by ttfboxd"

# ---- killed three times; nothing that was committed is lost, the box is free, the grid stays ----
captured() { grep -c '"result":"captured"' data/grass/records.jsonl 2>/dev/null; }
for _ in 1 2 3; do
    before=$(captured)
    for _ in $(seq 400); do
        [ "$(captured)" -gt "$before" ] && break
        sleep 0.05
    done
    kill -9 "$daemon"
    wait "$daemon" 2>/dev/null
    rm -f log
    begin_daemon X=1
    heard "<5>resuming"
    heard "<6>armed"
done
kill -TERM "$daemon"
ends 0
expect 0 "$TTFBOX" verify data/grass
[ "$(captured)" -ge 3 ] || fail "no slot was captured between the kills"
"$PYTHON" - data/grass <<'END' || fail "the grid moved"
import json, sys
segments, due = {}, []
for line in open(sys.argv[1] + "/records.jsonl", encoding="utf-8"):
    record = json.loads(line)
    if record.get("type") == "slot":
        due.append(record["due_ns"])
assert len(due) > 6, len(due)
assert {b - a for a, b in zip(due, due[1:])} == {400_000_000}, due
END

# ---- no plan yet; then one comes ----
rm -rf data log grass.yaml
begin_daemon X=1
heard "<5>waiting plan="
plan grass.yaml 'interval: 300ms' 'count: 3' 'shot: {exposure: 10ms}' 'keep: raw' 'reserve: 0B'
heard "<5>done slots=3"
kill -TERM "$daemon"
ends 0

# ---- the guardian is not there yet: tried again until it is ----
cat >>box.yaml <<'END'
lamps: {left: {backend: file, line: 0, max_on: 1h}}
guardian: {socket: SOCKET, file: wires}
panel: {backend: file, file: panel, led: {line: 0}, button: {line: 1}}
END
sed -i "s|SOCKET|$WORK/socket|" box.yaml
rm -rf data log
plan grass.yaml 'interval: 1s' 'count: 3' 'keep: raw' 'reserve: 0B' 'lamps: {mode: capture-only}' \
    'shot: {exposure: 10ms, lamps: {left: 100%}}'
begin_daemon X=1
heard "<4>retry"
heard "the lamp guardian does not answer"
lit=no
for _ in $(seq 400); do # the light flashes: somebody is needed
    [ "$(tail -c 1 panel)" = 1 ] && lit=yes && break
    sleep 0.02
done
[ $lit = yes ] || fail "the light does not flash"
# The button, held for 3 s: nothing is tried any more, over a boot too; held again it changes nothing.
press() { # LEVEL: the first byte is the button, the second the light
    printf '%s' "$1" | dd of=panel bs=1 conv=notrunc status=none
}
pressed() { # until WORDS are heard; a press that begins just while it is tried is not felt: again then
    for _ in 1 2 3 4 5; do
        press 1
        for _ in $(seq 100); do
            grep -qF -- "$1" log && break
            sleep 0.05
        done
        press 0
        grep -qF -- "$1" log && return
        sleep 0.3
    done
    fail "a press is not felt: $(cat log)"
}
pressed '<5>resting why="stopped by a person"'
heard "<5>button press=long"
grep -q '"state": *"stopped"' data/.ttfbox/run.json || fail "it is not written down: $(cat data/.ttfbox/run.json)"
kill -TERM "$daemon"
ends 0
rm -f log
begin_daemon X=1
heard '<5>resting why="stopped by a person"'
pressed "<5>button press=long"
sleep 0.5
grep -q "retry" log && fail "it is tried all the same: $(cat log)"
kill -TERM "$daemon"
ends 0
rm -rf log data/.ttfbox
begin_daemon X=1
heard "the lamp guardian does not answer"
"$LAMPD" --board box.yaml >guarding 2>&1 &
guardian=$!
heard "<5>done slots=3 captured=3"
kill -TERM "$daemon"
ends 0
kill -TERM $guardian
wait $guardian
[ "$(cat wires)" = 0 ] || fail "a lamp is left burning"
[ "$(tail -c 1 panel)" = 0 ] || fail "the light is left burning"
