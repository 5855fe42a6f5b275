#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ttfboxd listens at a network interface that comes late, gets another address, and is made anew, while it captures, and answers to its name
# there: in a network of its own, with a PC in another one at the other end.
. "$(dirname "$0")/network.bash"
. "$(dirname "$0")/cli.bash"
. "$(dirname "$0")/bench.bash"
. "$(dirname "$0")/server.bash"
. "$(dirname "$0")/daemon.bash"
[ -n "${DAEMON:-}" ] || exit 77 # built without a box

bench_box
data_in_memory
printf 'board: ./box.yaml\nplan: grass.yaml\ndata: data\nlisten: ["127.0.0.1:8417", "usb0:8417"]\n' >ttfboxd.yaml
plan grass.yaml 'interval: 500ms' 'count: 900' 'shot: {exposure: 10ms}' 'keep: raw' 'reserve: 0B'

plug() { # ADDRESS
    ip link add usb0 type veth peer name pc0
    ip link set usb0 up
    ip addr add "$1/24" dev usb0
    ip link set pc0 netns "$pc"
    at_pc ip link set pc0 up
    at_pc ip addr add 10.9.0.9/24 dev pc0
}
at_pc() { nsenter -t "$pc" -n "$@"; }
named() { # ADDRESS: a PC that asks all for the box's name is told this one, from it
    local got
    for _ in $(seq 40); do
        got=$(at_pc "$PYTHON" "$HERE/ask_name.py" 10.9.0.9 "ttfbox-$SERIAL.local")
        [ "$got" = "$1 from $1" ] && return 0
        sleep 0.25
    done
    fail "ttfbox-$SERIAL.local is '$got', not $1: $(cat log)"
}
there() { # ADDRESS
    get "http://$1:8417/api/v1/status" 200 -H "Authorization: Bearer $TOKEN"
    is state capturing
}

unshare -n sleep 600 & # the PC
pc=$!
for _ in $(seq 100); do
    [ "$(readlink /proc/$pc/ns/net)" != "$(readlink /proc/$$/ns/net)" ] && break
    sleep 0.05
done
begin_daemon
heard 'listening at="127.0.0.1:8417"'
heard 'unreachable at="usb0:8417"'
TOKEN=$(cat data/.ttfbox/token)
heard '<6>armed'
curl -sSN -H "Authorization: Bearer $TOKEN" http://127.0.0.1:8417/api/v1/events >told 2>&1 &
listener=$!

plug 10.9.0.1
heard 'listening at="10.9.0.1:8417" for="usb0:8417"'
there 10.9.0.1
SERIAL=$(json serial)
heard "named name=\"ttfbox-$SERIAL.local\" at=\"10.9.0.1\" for=\"usb0\""
named 10.9.0.1
[ -z "$(at_pc "$PYTHON" "$HERE/ask_name.py" 10.9.0.9 ttfbox-nobody.local)" ] || fail "it answers to others' names"
[ "$(at_pc "$PYTHON" "$HERE/ask_name.py" 10.9.0.9 "ttfbox-$SERIAL.local" plain)" = "10.9.0.1 from 10.9.0.1" ] || fail "plain DNS is not answered"
[ "$(at_pc "$PYTHON" "$HERE/ask_name.py" 10.9.0.9 "ttfbox-$SERIAL.local" other 10.9.0.1)" = "10.9.0.1 from 10.9.0.1" ] ||
    fail "that there is no IPv6 address, told to one who knows the other, keeps that one from who does not"
# Asked alone, it answers a neighbour, and nobody from elsewhere, though there is a way back; and nobody's thousands.
ask_alone() { # FROM
    at_pc "$PYTHON" "$HERE/ask_name.py" "$1" "ttfbox-$SERIAL.local" alone 10.9.0.1
}
at_pc ip addr add 10.8.0.9/32 dev pc0
ip route add 10.8.0.0/24 dev usb0
[ "$(ask_alone 10.9.0.9)" = "10.9.0.1 from 10.9.0.1" ] || fail "a neighbour that asks it alone is not answered"
[ -z "$(ask_alone 10.8.0.9)" ] || fail "it answers who is of no network of its own"
answers=$(at_pc "$PYTHON" "$HERE/ask_name.py" 10.9.0.9 "ttfbox-$SERIAL.local" often 10.9.0.1)
if [ "$answers" -lt 1 ] || [ "$answers" -gt 40 ]; then fail "of 200 questions at once $answers are answered"; fi
at_pc "$PYTHON" "$HERE/ask_name.py" 10.9.0.9 "ttfbox-$SERIAL.local" noise || fail "it does not answer after noise"
code=$(at_pc curl -sS -o out -w '%{http_code}' --resolve "ttfbox-$SERIAL.local:8417:10.9.0.1" -H "Authorization: Bearer $TOKEN" "http://ttfbox-$SERIAL.local:8417/api/v1/status")
[ "$code" = 200 ] || fail "by its name it is not reached: $code"

ip addr add 10.9.0.2/24 dev usb0 # the first one holds until it goes
ip addr del 10.9.0.1/24 dev usb0
ip addr replace 10.9.0.2/24 dev usb0
heard 'listening at="10.9.0.2:8417" for="usb0:8417"'
heard 'left at="10.9.0.1:8417"'
there 10.9.0.2
named 10.9.0.2

# The gadget is taken down and set up anew: another interface of the same name.
ip link del usb0
heard 'left at="10.9.0.2:8417"'
plug 10.9.0.1
heard 'listening at="10.9.0.1:8417" for="usb0:8417"' log 2
there 10.9.0.1
named 10.9.0.1
there 127.0.0.1

# Neither the run nor who listens by another address noticed.
code=$(curl -sS -o out -w '%{http_code}' -X POST -H "Authorization: Bearer $TOKEN" http://10.9.0.1:8417/api/v1/run/stop)
[ "$code" = 202 ] || fail "it is not stopped: $code $(cat out)"
heard '<5>resting'
kill -0 $listener 2>/dev/null || fail "who listens at another address was cut off: $(cat told)"
kill $listener
end_daemon
"$PYTHON" - told data/grass <<'END' || fail "slots were missed, or not told"
import json, sys
lines = open(sys.argv[1], encoding="utf-8").read().split("\n")
told = [json.loads(data[6:])["index"] for kind, data in zip(lines, lines[1:]) if kind == "event: slot"]
slots = [r for r in map(json.loads, open(sys.argv[2] + "/records.jsonl", encoding="utf-8")) if r["type"] == "slot"]
bad = [r for r in slots if r["result"] != "captured"]
assert not bad, bad
assert told and told == list(range(told[0], slots[-1]["index"] + 1)), (told, len(slots))
END

# A configuration that says nothing of it: the cable's network too, where there is one, and not a word where there is none.
printf 'board: ./box.yaml\ndata: data\n' >ttfboxd.yaml
: >log
begin_daemon
heard 'listening at="10.9.0.1:8417" for="usb0:8417"'
named 10.9.0.1
ip link del usb0
heard 'left at="10.9.0.1:8417"'
sleep 2
grep 'unreachable at="usb0' log && fail "it complains of a cable's network that nobody asked for"
end_daemon
