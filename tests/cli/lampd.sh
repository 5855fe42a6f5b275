#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ttfbox-lampd as a service manager runs it, on wires in a file that this script looks at from outside.
. "$(dirname "$0")/cli.bash"
[ -n "${LAMPD:-}" ] || exit 77 # built without a box

cat >box.yaml <<'END'
board: bench
cameras: {main: {backend: sim}}
clock: {backend: machine}
lamps:
  left: {backend: file, line: 0, max_on: 1h}
  right: {backend: file, line: 1, active_low: true}
guardian: {socket: SOCKET, file: wires, door: {line: 2}}
END
sed -i "s|SOCKET|$WORK/socket|" box.yaml

wires() { # WANT: within 20 s (a busy machine), what is outside sees this
    local got=
    for _ in $(seq 400); do
        got=$(cat wires)
        [ "$got" = "$1" ] && return 0
        sleep 0.05
    done
    fail "the wires are '$got' instead of '$1'"
}

guard() { # starts it and waits until it guards
    rm -f said
    "$LAMPD" --board box.yaml >said 2>&1 &
    guardian=$!
    for _ in $(seq 400); do
        grep -q guarding said && return 0
        sleep 0.05
    done
    fail "it does not guard: $(cat said)"
}

light() { # a client that lights the left lamp
    "$CHILD" "$WORK/socket" 3600000 waits >/dev/null &
    client=$!
    wires 110
}

# ---- the client dies ----
printf 111 >wires # whatever was before, lamps are dark from the first
guard
grep -q "guarding 2 lamps of board 'bench'" said || fail "$(cat said)"
wires 011
printf 0 | dd of=wires bs=1 seek=2 conv=notrunc status=none # the door closes
light
kill -9 $client
wires 010

# ---- the guardian dies: the wires stay, and are dark as soon as it is back ----
light
kill -9 $guardian
wait $guardian 2>/dev/null
wires 110
guard
wires 010
kill -9 $client 2>/dev/null

# ---- it is told to end ----
light
kill -TERM $guardian
wait $guardian || fail "it did not end well"
wires 010
[ ! -e socket ] || fail "its socket is left behind"
kill -9 $client 2>/dev/null

# ---- what is refused ----
expect 2 "$LAMPD"
said err "--board is missing"
expect 2 "$LAMPD" --board nowhere
said err "no such board"
expect 2 "$LAMPD" --board "$SOURCE/boards/sim/board.yaml"
said err "nothing to guard"
expect 2 "$LAMPD" --board box.yaml --config d.yaml
said err "one too many"
printf 'board: ./box.yaml\nplann: p.yaml\nzone: Atlantis\nretry: soon\nset: {guardian.file: elsewhere}\n' >d.yaml
printf 'board: %s\nplan: p.yaml\ndata: d\n' "$SOURCE/boards/sim/board.yaml" >none.yaml
"$PYTHON" "$HERE/manager.py" "$WORK/manages" "$WORK/manager" &
manager=$!
for _ in $(seq 400); do grep -qs listening manager && break; sleep 0.05; done
# A box without lamps: not to be tried again, and no failure, which an end before READY is to a manager.
expect 4 env NOTIFY_SOCKET="$WORK/manages" "$LAMPD" --config none.yaml
said err "nothing to guard"
for _ in $(seq 400); do grep -q "no lamps to guard" manager && break; sleep 0.05; done
grep -q "READY=1 | STATUS=no lamps to guard" manager || fail "its manager heard: $(cat manager)"
# A mistake is one.
expect 2 env NOTIFY_SOCKET="$WORK/manages" "$LAMPD" --config nowhere.yaml
[ "$(grep -c READY manager)" = 1 ] || fail "its manager heard: $(cat manager)"
kill $manager
wait $manager 2>/dev/null
expect 2 "$LAMPD" --config nowhere.yaml
expect 0 "$LAMPD" --help
said out "SIGTERM"
guard
expect 1 "$LAMPD" --board box.yaml
said err "another lamp guardian answers"
kill -TERM $guardian
wait $guardian

# ---- the daemon's board, with what its configuration changes of it, whatever else is wrong there ----
"$LAMPD" --config d.yaml >said 2>&1 &
guardian=$!
for _ in $(seq 400); do grep -q guarding said && break; sleep 0.05; done
[ "$(cat elsewhere)" = "010" ] || fail "it holds other wires than the daemon's board has: $(cat said)"
kill -TERM $guardian
wait $guardian

# ---- a lamp on a PWM channel beside one on a wire ----
pwm=sys/class/pwm/pwmchip0
channel_is() { # 1 or 0: within 20 s it is enabled, or not
    for _ in $(seq 400); do
        [ "$(cat $pwm/pwm0/enable)" = "$1" ] && return 0
        sleep 0.05
    done
    fail "the channel is $(cat $pwm/pwm0/enable)"
}
mkdir -p $pwm/pwm0
echo 2 >$pwm/npwm
for file in period duty_cycle enable; do echo 0 >$pwm/pwm0/$file; done
sed 's|left: .*|left: {backend: file, pwm: {chip: pwmchip0, channel: 0, period: 300us}}|; s|line: 1|line: 0|; s|line: 2|line: 1|' \
    box.yaml >dimmed.yaml
printf 00 >wires
rm -f said
# A process of a service's, which the manager's watchdog does not mean: it has nobody to feed.
env WATCHDOG_USEC=2000000 WATCHDOG_PID=1 NOTIFY_SOCKET="$WORK/nobody" \
    "$LAMPD" --board dimmed.yaml --sys sys >said 2>&1 &
guardian=$!
for _ in $(seq 400); do
    grep -q guarding said && break
    sleep 0.05
done
grep -q guarding said || fail "it does not guard: $(cat said)"
plan dimmed.plan.yaml 'interval: 10s' 'count: 2' 'mains: none' 'lamps: {mode: capture-only, settle: 0s}' \
    'shot: {exposure: 10.05ms, lamps: {left: 50%}}'
expect 0 "$TTFBOX" plan check dimmed.plan.yaml --board dimmed.yaml
said err "bands of 3.0%"
expect 0 "$TTFBOX" plan check dimmed.plan.yaml --board dimmed.yaml --json
is flicker_ppm.0 29851
"$CHILD" "$WORK/socket" 3600000 waits >/dev/null & # lights the left lamp
client=$!
channel_is 1
[ "$(cat $pwm/pwm0/duty_cycle)" = 300000 ] || fail "full light is $(cat $pwm/pwm0/duty_cycle) of 300000 ns"
kill -9 $client
channel_is 0
[ "$(cat $pwm/pwm0/duty_cycle) $(cat $pwm/pwm0/enable)" = "0 0" ] || fail "the channel stays lit"
kill -TERM $guardian
wait $guardian || fail "it did not end well"

# ---- a driver that hangs: another sensor's keeps no temperature away, and none keeps the guardian from its end ----
mkdir -p hot/class/hwmon/hwmon0 hot/class/hwmon/hwmon1
echo box >hot/class/hwmon/hwmon0/name
echo slow >hot/class/hwmon/hwmon1/name
echo 25000 >hot/class/hwmon/hwmon0/temp1_input
mkfifo hot/class/hwmon/hwmon1/humidity1_input # whoever opens it waits for ever
sed 's|max_on: 1h|max_temp: 60degC|; s|guardian: {|guardian: {temperature: box-temp, |' box.yaml >hot.yaml
cat >>hot.yaml <<'END'
sensors:
  box-humidity: {backend: sysfs, kind: humidity, bus: hwmon, device: slow}
  box-temp: {backend: sysfs, kind: temperature, bus: hwmon, device: box}
END
printf 010 >wires
rm -f said
"$LAMPD" --board hot.yaml --sys hot >said 2>&1 &
guardian=$!
for _ in $(seq 400); do grep -q guarding said && break; sleep 0.05; done
for _ in $(seq 400); do # until its first reading it is dark
    "$CHILD" "$WORK/socket" 3600000 waits >lit 2>/dev/null &
    client=$!
    for _ in $(seq 400); do
        { grep -q lit lit || ! kill -0 $client 2>/dev/null; } && break
        sleep 0.05
    done
    grep -q lit lit && break
done
wires 110
rm hot/class/hwmon/hwmon0/temp1_input
mkfifo hot/class/hwmon/hwmon0/temp1_input
exec 9>hot/class/hwmon/hwmon0/temp1_input # it is asked now, and told nothing
kill -TERM $guardian
for _ in $(seq 400); do kill -0 $guardian 2>/dev/null || break; sleep 0.05; done
kill -0 $guardian 2>/dev/null && fail "it does not end: $(cat said)"
wait $guardian || fail "it did not end well: $(cat said)"
grep -q "ended without it" said || fail "$(cat said)"
wires 010
[ ! -e socket ] || fail "its socket is left behind"
exec 9>&-
kill -9 $client 2>/dev/null
true
