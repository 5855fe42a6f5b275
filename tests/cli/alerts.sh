#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ttfbox-alertd: each part of a simulated box is killed in turn, and somebody is told: of a stopped capture within two slots.
. "$(dirname "$0")/cli.bash"
. "$(dirname "$0")/bench.bash"
[ -n "${ALERTD:-}" ] || exit 77 # built without a box
INTERVAL_S=2
box='' guardian='' previewer='' alertd='' receiver=''
# shellcheck disable=SC2086 # some of them may be empty
trap 'kill -9 $box $guardian $previewer $alertd $receiver 2>/dev/null; rm -rf "$WORK"' EXIT

now() { date +%s.%N; }
told() { # FROM WORDS...: when the first POST /hook after FROM came whose line has all the words; nothing if there is none
    local from=$1
    shift
    awk -v from="$from" -v words="$(printf '%s\001' "$@")" 'BEGIN { n = split(words, word, "\001") }
        $2 == "POST" && $3 ~ /^\/hook/ && $1 >= from {
            for (i = 1; i < n; i++) if (!index($0, word[i])) next
            print $1; exit
        }' received
}
hears() { # FROM SECONDS WORDS...: within so many seconds of FROM
    local from=$1 within=$2 when
    shift 2
    for _ in $(seq 300); do
        when=$(told "$from" "$@")
        [ -n "$when" ] && break
        sleep 0.1
    done
    [ -n "$when" ] || fail "nobody is told: $*: $(tail -3 received; tail -5 alertd.log)"
    awk -v from="$from" -v when="$when" -v within="$within" -v what="$*" \
        'BEGIN { printf "%s: after %.1f s\n", what, when - from; exit when - from > within }' || fail "too late: $*"
}
beats() { # FROM TO: heartbeats in between
    awk -v a="$1" -v b="$2" '$2 == "GET" && $1 >= a && $1 <= b' received | wc -l
}
slots() { grep -c '"type":"slot"' data/grass/records.jsonl 2>/dev/null; }
another() { # a slot is recorded
    local before
    before=$(slots)
    for _ in $(seq 300); do
        [ "$(slots)" -gt "$before" ] && return
        sleep 0.05
    done
    fail "no slot comes: $(tail -3 log)"
}

bench_box 'lamps: {left: {backend: file, line: 0, max_on: 1h}}' "guardian: {socket: $WORK/guardian, file: wires}"
plan grass.yaml "interval: ${INTERVAL_S}s" 'count: 1000' 'keep: raw' 'reserve: 0B' 'lamps: {mode: capture-only}' \
    'shot: {exposure: 10ms, lamps: {left: 100%}}'
"$PYTHON" "$HERE/alerts_receiver.py" received >port 2>&1 &
receiver=$!
for _ in $(seq 200); do [ -s port ] && break; sleep 0.05; done
base=http://127.0.0.1:$(cat port)
cat >note <<'END'
#!/bin/sh
[ "$*" ] && echo "$@" >>"$0.args"
cat >>"$0.said"
echo >>"$0.said"
END
printf '#!/bin/sh\nsleep 1000 &\nsleep 1000\n' >hang
chmod +x note hang
cat >"$WORK/command" <<'END'
#!/bin/sh
cat >>"$0.said"
END
chmod +x "$WORK/command"
cp note mailer
cp note mqtt
cat >ttfboxd.yaml <<END
board: ./box.yaml
plan: grass.yaml
data: data
retry: 300ms
listen: ["unix:$WORK/http"]
alerts:
  hooks:
    hanging: {command: $WORK/hang, timeout: 3s}
    deaf: {webhook: "$base/hang?token=SECRET1"}
    web: {webhook: "$base/hook?token=SECRET2"}
    failing: {webhook: "$base/no?token=SECRET3"}
    command: {command: $WORK/command}
    mail: {mail: me@example.org, program: $WORK/mailer, from: alarm}
    bus: {mqtt: box/alerts, host: broker, program: $WORK/mqtt}
  parts: {daemon: $WORK/http, guardian: $WORK/guardian, preview: lock}
  grace: 1s
  begin: 3s
  heartbeat: $base/beat?token=SECRET4
  every: 500ms
END
expect 2 "$ALERTD"
said err "--config is missing"
sed 's/from: alarm/from: panic/' ttfboxd.yaml >bad.yaml
expect 2 "$ALERTD" --config bad.yaml
said err "bad.yaml:13:"
grep -q SECRET err && fail "a secret in an error"
expect 0 "$DAEMON" --config bad.yaml --check # it is no reason not to capture
expect 0 "$ALERTD" --config ttfboxd.yaml --check

# ---- a trial: who would be told, and who not, before the weeks begin; without a secret in what is said ----
expect 1 "$ALERTD" --config ttfboxd.yaml --try
for hook in hanging failing; do grep -Eq "^$hook +FAILED: " out || fail "the trial of $hook: $(cat out)"; done
for hook in web command mail bus heartbeat; do grep -Eq "^$hook +took it$" out || fail "the trial of $hook: $(cat out)"; done
grep -q SECRET out err && fail "a secret in what a trial says"
grep -q '"kind":"trial"' command.said || fail "no trial came to the command"
grep -q '^Subject: .*notice: a trial' mailer.said || fail "no trial came by mail"
[ -n "$(told 0 '"kind":"trial"')" ] || fail "no trial was posted"
rm -f ./*.said ./*.args
printf '%s\n' 'data: data' 'alerts: {hooks: {me: {mail: me@example.org, program: /nowhere/sendmail}}}' >nowhere.yaml
expect 1 "$ALERTD" --config nowhere.yaml --try
said out "FAILED: the program cannot be started: No such file or directory"
expect 124 timeout -k 5 2 "$ALERTD" --config nowhere.yaml # and so when it begins
said err 'hook=me why="its program cannot be run: No such file or directory'
echo 'data: data' >nobody.yaml
expect 1 "$ALERTD" --config nobody.yaml --try
said out "nobody would be told"

start_daemon() { "$DAEMON" --config ttfboxd.yaml >>log 2>&1 & box=$!; }
start_guardian() { "$LAMPD" --board box.yaml >>guarding 2>&1 & guardian=$!; }
# By a sanitizer it needs more address space than it allows itself: then something else holds its lock.
start_preview() {
    if sanitized "$PREVIEW"; then
        mkdir -p data/.preview
        "$PYTHON" -c 'import fcntl, time
lock = open("data/.preview/lock", "w")
fcntl.flock(lock, fcntl.LOCK_EX)
time.sleep(600)' &
    else
        "$PREVIEW" --folder data --ttfbox "$TTFBOX" --eager >>previewing 2>&1 &
    fi
    previewer=$!
}
start_alertd() { "$ALERTD" --config ttfboxd.yaml >>alertd.log 2>&1 & alertd=$!; }
gone() { # PROCESS
    kill -9 "$1"
    wait "$1" 2>/dev/null
}
# ---- a run that cannot begin: said with why, and the heart is silent; one that begins is no false alarm ----
mkdir data
start_alertd
begun=$(now)
start_daemon
start_preview
hears "$begun" 8 '"kind":"not-begun"' '"severity":"alarm"' '"dataset":"grass"' "retrying" "the lamp guardian does not answer"
silent=$(now)
sleep 1
[ "$(beats "$silent" "$(now)")" = 0 ] || fail "the heart beats although the capture cannot begin"
start_guardian
hears "$silent" 30 '"kind":"going-on"'
begun=$(now)
another
another
[ "$(beats "$begun" "$(now)")" -ge 2 ] || fail "no heartbeat: $(cat alertd.log)"
[ -z "$(told "$begun" '"kind":"stopped"')" ] || fail "a capture that runs is said to have stopped"
[ -z "$(told "$begun" '"kind":"part-gone"')" ] || fail "a part that lives is said to be gone: $(cat received)"

# ---- the daemon is killed ----
at=$(now)
gone "$box"
hears "$at" $((2 * INTERVAL_S)) '"kind":"stopped"' '"severity":"alarm"' '"dataset":"grass"'
hears "$at" 3 '"kind":"part-gone"' "the daemon"
silent=$(now)
sleep 2
[ "$(beats "$silent" "$(now)")" = 0 ] || fail "the heart beats although the capture has stopped"
start_daemon
hears "$silent" 30 '"kind":"going-on"'
hears "$silent" 30 '"kind":"part-back"' "the daemon"

# ---- it hangs: it answers to nobody, and lives ----
another
at=$(now)
kill -STOP "$box"
hears "$at" $((2 * INTERVAL_S)) '"kind":"stopped"'
kill -CONT "$box"
hears "$at" 30 '"kind":"going-on"'

# ---- the guardian is killed: the capture goes on, the daemon's own event is told ----
another
at=$(now)
gone "$guardian"
hears "$at" 3 '"kind":"part-gone"' "the guardian"
hears "$at" $((3 * INTERVAL_S)) '"kind":"event"' lamp
start_guardian
hears "$at" 30 '"kind":"part-back"' "the guardian"

# ---- the preview is killed: the capture does not notice ----
another
at=$(now)
gone "$previewer"
hears "$at" 3 '"kind":"part-gone"' "the preview"
another
[ -z "$(told "$at" '"kind":"stopped"')" ] || fail "the capture stopped with the preview"
start_preview
hears "$at" 30 '"kind":"part-back"' "the preview"

# ---- the alerter is killed: the heartbeat is missed, elsewhere; the capture does not notice ----
gone "$alertd"
at=$(now)
another
another
[ "$(beats "$at" "$(now)")" = 0 ] || fail "who else sends a heartbeat?"
start_alertd
sleep 2
[ "$(beats "$at" "$(now)")" -ge 1 ] || fail "no heartbeat again"

# ---- a person stops it: told as that, once, and the heart goes on beating; gone on with, that is told ----
another
asked() { # PATH [curl's options]
    curl -sSf --unix-socket http -H "Authorization: Bearer $(cat data/.ttfbox/token)" "${@:2}" "http://localhost/api/v1/$1" >out ||
        fail "$1 is refused"
}
at=$(now)
asked run/stop -X POST
hears "$at" $((2 * INTERVAL_S)) '"kind":"stopped-by-person"' '"severity":"warning"' '"dataset":"grass"'
silent=$(now)
sleep $((2 * INTERVAL_S))
[ "$(beats "$silent" "$(now)")" -ge 2 ] || fail "the heart does not beat, as if something were wrong"
[ "$(awk -v at="$at" '$1 >= at && / POST \/hook/' received | wc -l)" = 1 ] || fail "told more than once: $(tail -3 received)"
asked run -H 'Content-Type: application/json' -d '{}'
hears "$at" 30 '"kind":"going-on"'
another
grep -q '"reason":"stopped by a person"' data/grass/records.jsonl || fail "its slots are said to be lost by something else"
[ -z "$(told "$at" '"kind":"slots-lost"' "stopped by a person")" ] || fail "slots that nobody wanted are said to be lost"

# ---- all kinds of hooks were told, whatever the hanging ones did ----
grep -q '"kind":"stopped"' command.said || fail "the command was not told"
"$PYTHON" -c 'import json
for line in open("command.said"):
    json.loads(line)' || fail "an alert is not one line of its own: $(cat command.said)"
grep -q '"kind":"stopped"' mqtt.said || fail "the broker was not told"
grep -qF -- '-h broker -t box/alerts -q 1 -s' mqtt.args || fail "not as mosquitto_pub is called: $(cat mqtt.args)"
grep -q '^To: me@example.org' mailer.said || fail "no mail"
grep -q '^Subject: .*alarm: the capture has stopped' mailer.said || fail "a mail without its matter"
grep -q 'the preview does not answer' mailer.said && fail "a mail about less than an alarm"
grep -q ' POST /hang' received || fail "the deaf one was not tried"
[ "$(grep -c ' POST /no' received)" -ge 2 ] || fail "what failed was not tried again"
grep -q "hook=hanging .*took too long" alertd.log || fail "the hanging program is not ended: $(cat alertd.log)"

# ---- secrets are told to nobody ----
grep -q 'SECRET\|example.org' alertd.log && fail "a secret in the log: $(grep SECRET alertd.log | head -3)"
tr '\0' ' ' <"/proc/$alertd/cmdline" | grep -q SECRET && fail "a secret in the list of processes"

# ---- told to end, it ends at once, with hooks that hang ----
at=$(now)
kill -TERM "$alertd"
wait "$alertd" || fail "it ended with $?"
awk -v a="$at" -v b="$(now)" 'BEGIN { exit b - a > 5 }' || fail "it takes long to end"
kill -TERM "$box"
wait "$box"
expect 0 "$TTFBOX" verify data/grass
