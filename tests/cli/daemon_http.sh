#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ttfboxd asked by HTTP, on a simulated camera in real time: started, watched, paused, noted on, stopped, started again; who may not; crowds.
# In a session of its own: what else this machine has to do gives way to all of it (bench.bash).
[ -n "${OWN_SESSION:-}" ] || OWN_SESSION=1 exec setsid -w bash "$0"
. "$(dirname "$0")/cli.bash"
. "$(dirname "$0")/bench.bash"
. "$(dirname "$0")/server.bash"
. "$(dirname "$0")/daemon.bash"
[ -n "${DAEMON:-}" ] || exit 77 # built without a box

bench_first
bench_box 'lamps: {left: {backend: sim}}' 'sensors: {box-temp: {backend: sim, kind: temperature}}'
data_in_memory
printf 'board: ./box.yaml\ndata: data\nretry: 300ms\nlisten: ["127.0.0.1:0", "unix:cable"]\nnames: [one, two, three, four, five, greenhouse]\n' >ttfboxd.yaml

start() {
    : >log
    begin_daemon
    heard 'listening at="unix:'
    daemon_url
    TOKEN=$(cat data/.ttfbox/token)
    ME=(-H "Authorization: Bearer $TOKEN")
}
json_of() { # FILE URL STATUS [curl's options]: a JSON or YAML file sent
    local file=$1 type=application/json
    case $file in *.yaml) type=application/yaml ;; esac
    shift
    get "$1" "$2" "${ME[@]}" -H "Content-Type: $type" --data-binary "@$file" "${@:3}"
}
post() { # URL STATUS JSON [curl's options]
    printf '%s' "$3" >asked.json
    json_of asked.json "$1" "$2" "${@:4}"
}
ask_status() { get "$URL/status" 200 "${ME[@]}"; }
answered() { # what was asked last is done
    local number
    number=$(json number)
    for _ in $(seq 200); do
        get "$URL/run/asked/$number" 200 "${ME[@]}"
        [ "$(json answered)" = true ] && break
        sleep 0.05
    done
    is 'done' true
}
none_missed() { # DATASET: but for slots that were paused, or passed while the program did not run yet
    "$PYTHON" - "data/$1" <<'END' || fail "slots of $1 were missed"
import json, sys
bad = [r for r in map(json.loads, open(sys.argv[1] + "/records.jsonl", encoding="utf-8")) if r["type"] == "slot" and
       r["result"] not in ("captured", "paused") and r.get("reason") not in ("the program was not running", "the box was getting ready", "stopped by a person")]
assert not bad, bad
END
}
slots() { grep -c '"type":"slot"' "data/$1/records.jsonl" 2>/dev/null; }

start
[ "$(stat -c %a cable)" = 660 ] || fail "the cable's socket is not its group's"
expect 0 "$TTFBOX" token ttfboxd.yaml
[ "$(cat out)" = "$TOKEN" ] || fail "ttfbox token prints another"

# ---- who may ----
get "$URL/status" 401
curl -sS --unix-socket cable http://localhost/api/v1/status >out || fail "the cable does not read"
is state idle
is simulated true
get "$URL/health" 200 -H 'Host: greenhouse:80'
get "$URL/health" 421 -H 'Host: elsewhere.example'
printf '{"plan":"first"}' >asked.json
get "$URL/run" 401 -H 'Content-Type: application/json' --data-binary @asked.json
get "$URL/run" 401 -H 'Content-Type: application/json' --data-binary @asked.json -H 'Authorization: Bearer 0123456789abcdef'
code=$(curl -sS -o out -w '%{http_code}' --unix-socket cable -X POST http://localhost/api/v1/run/stop)
[ "$code" = 401 ] || fail "the cable changes the box without a token: $code"
code=$(curl -sS -o out -w '%{http_code}' --unix-socket cable http://localhost/api/v1/live)
[ "$code" = 401 ] || fail "the cable has live view without a token: $code"

# ---- a browser: the token for a cookie; another page's requests change nothing ----
origin=${URL%/api/v1}
post "$URL/session" 401 '{"token":"0123456789abcdef"}'
post "$URL/session" 200 "{\"token\":\"$TOKEN\"}"
grep -qi '^Set-Cookie: ttfbox-[0-9]*=.*; HttpOnly; SameSite=Strict' headers || fail "no such cookie"
cookie=$(sed -n 's/^Set-Cookie: \([^;]*\);.*/Cookie: \1/Ip' headers)
get "$URL/status" 200 -H "$cookie"
get "$URL/status" 401 -H "${cookie%?}x"
JSON=(-H "$cookie" -H 'Content-Type: application/json' -d '{}')
get "$URL/run" 403 "${JSON[@]}"
get "$URL/run" 403 "${JSON[@]}" -H "Origin: $origin"
get "$URL/run" 403 "${JSON[@]}" -H "X-Ttfbox: 1"
get "$URL/run" 403 "${JSON[@]}" -H "X-Ttfbox: 1" -H 'Origin: http://elsewhere.example'
get "$URL/run" 403 "${JSON[@]}" -H "X-Ttfbox: 1" -H "Origin: $origin" -H 'Sec-Fetch-Site: cross-site'
get "$URL/run" 404 "${JSON[@]}" -H "X-Ttfbox: 1" -H "Origin: $origin" -H 'Sec-Fetch-Site: same-origin' # nothing was stopped
get "$URL/run" 415 "${ME[@]}" -d 'plan=first'
head -c 300000 /dev/zero >large.yaml
# Asked first: a client that sends at once may find the connection closed before it reads why.
json_of large.yaml "$URL/plans/check" 413 -H 'Expect: 100-continue'
printf '{"token":"%02000d"}' 0 >long.json
json_of long.json "$URL/session" 413 # of whoever has no token little is taken
post "$URL/run" 400 '{"plam":"first"}'
get "$URL/session" 200 -H "$cookie"
is change true
get "$URL/session" 200
is read false

# ---- boards: those that are there, with the plans in the folder beside them; checked; sent, kept, and never put in force ----
mkdir -p boards/another/plans
sed 's/^board: .*/board: another/' box.yaml >boards/another/board.yaml
plan boards/another/plans/example.yaml 'interval: 500ms' 'count: 9' 'shot: {exposure: 10ms}'
echo 'no: plan' >boards/another/plans/none.yaml
get "$URL/boards" 200 "${ME[@]}"
is own bench
"$PYTHON" - out <<'END' || fail "the boards: $(cat out)"
import json, sys
boards = {b["name"]: b["plans"] for b in json.load(open(sys.argv[1], encoding="utf-8"))["boards"]}
assert boards["bench"] == [] and boards["another"] == ["example"], boards
END
get "$URL/boards" 401
get "$URL/boards/another" 200 "${ME[@]}"
cmp -s out boards/another/board.yaml || fail "the board is another"
get "$URL/boards/bench" 200 "${ME[@]}"
cmp -s out box.yaml || fail "the box's own board is another"
get "$URL/boards/another/plans/example" 200 "${ME[@]}"
cmp -s out boards/another/plans/example.yaml || fail "the board's plan is another"
get "$URL/boards/another/plans/nothing" 404 "${ME[@]}"
get "$URL/boards/nobody" 404 "${ME[@]}"
get "$URL/boards/another/plans/..%2fboard" 404 "${ME[@]}" --path-as-is
sed 's/max_on: [^,}]*/max_on: 3 parsecs/' "$SOURCE/boards/rpi4/board.yaml" >wrong.yaml
json_of "$SOURCE/boards/rpi4/board.yaml" "$URL/boards/check" 200
is ok true
is board.simulated false
json_of wrong.yaml "$URL/boards/check" 200
is ok false
json findings.0.where | grep -q '^board:[0-9]*:' || fail "it does not say where: $(cat out)"
get "$URL/boards/check" 401 -H 'Content-Type: application/yaml' --data-binary @wrong.yaml
sed 's/^board: .*/board: mine/' box.yaml >mine.yaml
json_of mine.yaml "$URL/boards/mine" 200 -X PUT
is board.name mine
get "$URL/boards/mine" 200 "${ME[@]}"
cmp -s out mine.yaml || fail "the board that was sent is another"
get "$URL/boards/mine/plans/example" 404 "${ME[@]}"
get "$URL/boards" 200 "${ME[@]}"
"$PYTHON" - out <<'END' || fail "the boards: $(cat out)"
import json, sys
told = json.load(open(sys.argv[1], encoding="utf-8"))
boards = {b["name"]: b["sent"] for b in told["boards"]}
assert told["own"] == "bench" and boards["mine"] and not boards["bench"] and not boards["another"], told
END
json_of mine.yaml "$URL/boards/mine" 409 -X PUT # what lies there stays what it is
json_of mine.yaml "$URL/boards/other" 400 -X PUT
said out "calls itself 'mine'"
json_of wrong.yaml "$URL/boards/rpi5" 400 -X PUT
for name in bench another; do # in place of the box's own limits, or of those that came with it
    sed "s/^board: .*/board: $name/; s/left: {backend: sim/left: {backend: sim, max_on: 9h/" box.yaml >theirs.yaml
    json_of theirs.yaml "$URL/boards/$name" 403 -X PUT
    get "$URL/boards/$name" 403 "${ME[@]}" -X DELETE
done
said out "came with the box"
if grep -q "another name" out; then fail "who takes a board away is told to take another name"; fi
# One that was sent, and that a board of the same name hides since then: it can be taken away, the other one cannot.
sed 's/^board: .*/board: late/' box.yaml >late.yaml
json_of late.yaml "$URL/boards/late" 200 -X PUT
mkdir boards/late
cp late.yaml boards/late/board.yaml
get "$URL/boards/late" 200 "${ME[@]}" -X DELETE
[ ! -e data/.ttfbox/boards/late.yaml ] || fail "a board that was sent and is hidden stays for ever"
get "$URL/boards/late" 403 "${ME[@]}" -X DELETE
json_of late.yaml "$URL/boards/late" 403 -X PUT
said out "take another name"
rm -r boards/late
# What is no file is no board.
mkdir data/.ttfbox/boards/folder.yaml
get "$URL/boards/folder" 404 "${ME[@]}"
get "$URL/boards/folder" 404 "${ME[@]}" -X DELETE
sed 's/^board: .*/board: folder/' box.yaml >folder.yaml
json_of folder.yaml "$URL/boards/folder" 500 -X PUT
rmdir data/.ttfbox/boards/folder.yaml
[ -z "$(find data/.ttfbox/boards -name '*.tmp')" ] || fail "what could not be put in place stays"
# Nor is one that is too long to have been one.
mkdir boards/long
{ cat mine.yaml && yes '# nothing' | head -c 300000; } >boards/long/board.yaml
get "$URL/boards/long" 500 "${ME[@]}"
json_of boards/long/board.yaml "$URL/boards/toolong" 413 -X PUT
rm -r boards/long
# Of many who send one of the same name at once one is served, and what lies there is theirs whole.
sed 's/^board: .*/board: race/' box.yaml >race.yaml
"$PYTHON" - "$URL" "$TOKEN" race.yaml data/.ttfbox/boards/race.yaml <<'END' || fail "of many who send at once"
import http.client, os, socket, sys, threading, urllib.parse
url, token, path, there = sys.argv[1:]
at, board = urllib.parse.urlsplit(url), open(path, "rb").read()
head = {"Authorization": "Bearer " + token, "Content-Type": "application/yaml"}
def send(k, gate, answers):
    body = board + b"# %d\n" % k * (1000 * k)
    line = http.client.HTTPConnection(at.hostname, at.port, timeout=60)
    line.putrequest("PUT", at.path + "/boards/race")
    for name, value in {**head, "Content-Length": str(len(body))}.items():
        line.putheader(name, value)
    line.endheaders(body[:-1])
    line.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    gate.wait()
    line.send(body[-1:])
    answers[k] = line.getresponse().status, body
for turn in range(20):
    answers, gate = {}, threading.Barrier(6)
    crowd = [threading.Thread(target=send, args=(k, gate, answers)) for k in range(1, 7)]
    for one in crowd: one.start()
    for one in crowd: one.join()
    taken = [body for status, body in answers.values() if status == 200]
    assert sorted(status for status, _ in answers.values()) == [200] + [409] * 5, (turn, [a[0] for a in answers.values()])
    assert open(there, "rb").read() == taken[0], turn
    line = http.client.HTTPConnection(at.hostname, at.port, timeout=60)
    line.request("DELETE", at.path + "/boards/race", headers=head)
    assert line.getresponse().status == 200, turn
END
json_of mine.yaml "$URL/boards/..%2f..%2fmine" 404 -X PUT --path-as-is
get "$URL/boards/mine" 401 -X DELETE
cp ttfboxd.yaml kept.yaml
sed 's|^board: .*|board: data/.ttfbox/boards/mine.yaml|' kept.yaml >ttfboxd.yaml
expect 0 "$DAEMON" --config ttfboxd.yaml --check
get "$URL/boards/mine" 403 "${ME[@]}" -X DELETE # somebody at the box has decided for it: at the next start it holds
cp kept.yaml ttfboxd.yaml
get "$URL/boards/mine" 200 "${ME[@]}" -X DELETE
get "$URL/boards/mine" 404 "${ME[@]}"
get "$URL/boards/mine" 404 "${ME[@]}" -X DELETE

# ---- plans: checked before they are in place ----
plan first.yaml 'interval: 500ms' 'count: 900' 'lamps: {mode: continuous}' 'shot: {exposure: 10ms, lamps: {left: 100%}}' 'keep: both' 'reserve: 0B'
plan wrong.yaml 'interval: 500ms' 'count: 24' 'shot: {exposure: 10s}' 'reserve: 0B'
json_of first.yaml "$URL/plans/check" 200
is ok true
is figures.slots 900
json_of wrong.yaml "$URL/plans/check" 200
is ok false
json_of wrong.yaml "$URL/plans/first" 400 -X PUT
get "$URL/plans/first" 404 "${ME[@]}"
json_of first.yaml "$URL/plans/first" 200 -X PUT
get "$URL/plans/first" 200 "${ME[@]}"
cmp -s out first.yaml || fail "the plan is another"
json_of first.yaml "$URL/plans/..%2f..%2fescaped" 404 -X PUT --path-as-is
[ -z "$(find -L . -name 'escaped*')" ] || fail "a plan left its folder"
json_of first.yaml "$URL/plans/spare" 200 -X PUT
get "$URL/plans/spare" 200 "${ME[@]}" -X DELETE
get "$URL/plans/spare" 404 "${ME[@]}"
get "$URL/box" 200 "${ME[@]}"
is cameras.0.width 96

# ---- between runs a picture from the camera; without one there is no newest ----
get "$URL/live" 200 "${ME[@]}"
[ "$(head -c 2 out | xxd -p)" = ffd8 ] || fail "no JPEG"
grep -qi '^X-Ttfbox-Live: camera' headers || fail "from elsewhere"
grep -Eqi '^X-Ttfbox-Exposure-Ns: [1-9][0-9]*' headers || fail "a picture that exposed by itself does not say how long"
get "$URL/live?region=10,10,20,20&exposure_ns=5000000&gain_milli=2000" 200 "${ME[@]}"
ns=$(sed -n 's/^X-Ttfbox-Exposure-Ns: \([0-9]*\)\r$/\1/Ip' headers)
((ns > 4500000 && ns < 5500000)) || fail "asked for 5 ms, it says $ns ns"
grep -Eqi '^X-Ttfbox-Gain-Milli: 2000' headers || fail "the gain is not said"
get "$URL/live?region=90,60,20,20" 400 "${ME[@]}"
get "$URL/latest" 404 "${ME[@]}"

# ---- a run by request, watched by events, with a crowd, with deaf listeners, and with one who means harm ----
"$PYTHON" "$HERE/box.py" "$URL" "$TOKEN" watch 16 60 >watched 2>&1 &
watcher=$!
mkfifo held
"$PYTHON" "$HERE/box.py" "$URL" "$TOKEN" deaf 20 <held >listening 2>&1 &
exec 9>held
heard deaf listening
post "$URL/run" 202 '{"plan":"first"}'
is dataset first
state capturing
post "$URL/run" 409 '{"plan":"first","dataset":"other"}'
get "$URL/status" 200 "${ME[@]}"
is run.asked_by request
is run.slots 900
"$PYTHON" "$HERE/box.py" "$URL" "$TOKEN" crowd 50 3 >readers 2>&1 || fail "the crowd: $(cat readers)"
get "$URL/live" 200 "${ME[@]}"
grep -qi '^X-Ttfbox-Live: latest' headers || fail "the camera was touched in a run"
get "$URL/latest" 200 "${ME[@]}"
tag=$(sed -n 's/^ETag: \(.*\)\r$/\1/Ip' headers)
"$PYTHON" "$HERE/hostile.py" "${URL#http://}" 40 || fail "a hostile client had its way"
get "$URL/status" 200 "${ME[@]}"
slots=$(($(json run.done) + 16))
[ $slots -ge 20 ] || slots=20 # more than are watched
post "$URL/run/change" 202 "{\"count\":$slots}"
answered
state idle
is run.sealed true
is run.results.captured $slots
wait "$watcher" || fail "events: $(cat watched)"
exec 9>&-
none_missed first
expect 0 "$TTFBOX" verify data/first
get "$URL/latest" 200 "${ME[@]}" -H "If-None-Match: $tag"
sed -n 's/^ETag: \(.*\)\r$/\1/Ip' headers >tag2
get "$URL/latest" 304 "${ME[@]}" -H "If-None-Match: $(cat tag2)"

# ---- a preview of it that is made, and made anew, is told to whoever listens ----
curl -sSN "${ME[@]}" "$URL/events" >told 2>/dev/null &
listener=$!
mkdir -p data/.preview/first
for images in 12 24; do
    printf '{"state":"ready","images":%d,"frames":[{"path":"g1/000.jpg","slot":0}]}' $images >data/.preview/state.tmp
    mv data/.preview/state.tmp data/.preview/first/state.json
    for _ in $(seq 200); do
        [ "$(grep -c '^event: preview' told)" -ge $((images / 12)) ] && break
        sleep 0.05
    done
done
kill $listener
[ "$(grep -c '^event: preview' told)" = 2 ] || fail "not told twice of previews: $(cat told)"
grep -q '"dataset":"first","path":"/api/v1/datasets/first/preview"' told || fail "not told of which: $(cat told)"

# ---- notes ----
post "$URL/datasets/first/notes" 200 '{"text":"mould at the edge","slots":[[3,5]],"tags":["exclude"]}'
grep -q '"text":"mould at the edge"' data/first/notes.jsonl || fail "the note is not in the dataset"
post "$URL/datasets/first/notes" 400 '{}'
post "$URL/datasets/nobody/notes" 404 '{"text":"x"}'
expect 0 "$TTFBOX" verify data/first

# ---- pause, go on, more slots; killed within the run it is gone on with, as it was when it was asked for ----
plan second.yaml 'interval: 500ms' 'count: 500' 'shot: {exposure: 10ms}' 'keep: raw' 'reserve: 0B'
json_of second.yaml "$URL/plans/second" 200 -X PUT
post "$URL/run" 202 '{"plan":"second","dataset":"two"}'
state capturing
post "$URL/run/pause" 202 '{"reason":"watering"}'
answered
state paused
get "$URL/run/resume" 202 "${ME[@]}" -X POST
answered
state capturing
post "$URL/run/change" 202 '{"count":400}'
answered
# A PC's time, where there is none better, and in the dataset then.
get "$URL/status" 200 "${ME[@]}"
trust=$(json time.trust)
post "$URL/time" 400 '{"utc_ns":5}'
post "$URL/time" 200 "{\"utc_ns\":$(date +%s)000000000}"
if [ "$trust" = none ]; then
    is taken true
    get "$URL/status" 200 "${ME[@]}"
    is time.trust host
    heard '<5>time from=host'
    heard 'UTC is now vouched for by host' data/two/events.jsonl
    heard '"trust":"host"' data/two/records.jsonl
else
    is taken false
    get "$URL/status" 200 "${ME[@]}"
    is time.trust "$trust"
fi
get "$URL/plans/second" 200 "${ME[@]}" -X DELETE
before=$(slots two)
end_daemon KILL
start
state capturing
is run.dataset two
is run.asked_by request
[ "$(json run.done)" -ge "$before" ] || fail "it began anew"
heard '<5>resuming'

# ---- who listened before that start, or to what is not remembered, is told that something was missed; who missed nothing is not ----
first_event() { # LAST-EVENT-ID
    timeout 20 curl -sSN "${ME[@]}" ${1:+-H "Last-Event-ID: $1"} "$URL/events" 2>/dev/null | sed -n '/^id: /{s///;h}; /^event: /{G;s/\n/ /;p;q}'
}
before=$(sed -n 's/^id: //p' told | tail -n 1)
[ -n "$before" ] || fail "events have no ids"
case $(first_event "$before") in 'event: missed'*) ;; *) fail "what it did before that start was not missed: $(first_event "$before")" ;; esac
now=$(first_event "")
case $now in 'event: missed'*) fail "who listens for the first time missed nothing" ;; esac
case $(first_event "${now##* }") in 'event: missed'*) fail "who heard $now missed nothing" ;; esac
case $(first_event "${now##* }0000000") in 'event: missed'*) ;; *) fail "of what is to come nobody has heard" ;; esac

# ---- stopped, it stays so, over a boot too, until it is gone on with ----
get "$URL/run/stop" 202 "${ME[@]}" -X POST
state stopped
is why "stopped by a person"
get "$URL/run/stop" 404 "${ME[@]}" -X POST
end_daemon
start
state stopped
before=$(slots two)
sleep 1
[ "$(slots two)" = "$before" ] || fail "it went on by itself"
post "$URL/run" 202 '{}'
state capturing
get "$URL/status" 200 "${ME[@]}"
is run.dataset two
heard '"reason":"stopped by a person"' data/two/records.jsonl
heard 'slots lost: stopped by a person' data/two/events.jsonl
get "$URL/run/stop" 202 "${ME[@]}" -X POST
state stopped
# Nothing is added to what is sealed, nor to a dataset of another plan.
sealed=$(sha256sum <data/first/SHA256SUMS)
post "$URL/run" 409 '{"plan":"first"}'
said out sealed
post "$URL/run" 409 '{"plan":"first","dataset":"two"}'
said out 'another plan'
state stopped
[ "$(sha256sum <data/first/SHA256SUMS)" = "$sealed" ] || fail "a sealed dataset was changed"
end_daemon

# ---- orders that cannot be read: nothing runs, everything can be asked, and a person goes on ----
echo '{"state":' >data/.ttfbox/run.json
start
state stopped
json why | grep -q 'run.json.unreadable' || fail "it does not say why: $(json why)"
get "$URL/datasets" 200 "${ME[@]}"
get "$URL/run" 404 "${ME[@]}" -X POST -H 'Content-Type: application/json' -d '{}' # nothing is known that could go on
json_of second.yaml "$URL/plans/second" 200 -X PUT
post "$URL/run" 202 '{"plan":"second","dataset":"two"}'
state capturing
get "$URL/run/stop" 202 "${ME[@]}" -X POST
state stopped
end_daemon
none_missed two
expect 0 "$TTFBOX" verify data/two
grep -q '"reason":"watering"' data/two/records.jsonl || fail "the pause is not in the records"

# ---- a run that went on in its second storage rests: all its slots are counted, after a boot, and when the first one comes late ----
mkdir second
cp box.yaml whole.yaml
echo '  faults: [{kind: read-only, at: 8s, target: first}]' >>box.yaml
start
plan third.yaml 'interval: 500ms' 'count: 400' 'shot: {exposure: 10ms}' 'keep: raw' 'reserve: 0B' "storage: {second: $WORK/second}"
json_of third.yaml "$URL/plans/third" 200 -X PUT
post "$URL/run" 202 '{"plan":"third","dataset":"three"}'
for _ in $(seq 400); do
    [ "$(grep -c '"type":"slot"' second/three/records.jsonl 2>/dev/null)" -ge 3 ] 2>/dev/null && break
    sleep 0.05
done
get "$URL/run/stop" 202 "${ME[@]}" -X POST
state stopped
all=$(($(slots three) + $(grep -c '"type":"slot"' second/three/records.jsonl)))
[ "$(slots three)" -ge 1 ] || fail "it moved before its first slot: $(cat log)"
[ "$all" -gt "$(slots three)" ] || fail "it did not move: $(cat log)"
counted() { # SLOTS: within 15 s
    for _ in $(seq 300); do
        get "$URL/status" 200 "${ME[@]}"
        [ "$(json run.done)" = "$1" ] && return 0
        sleep 0.05
    done
    fail "$(json run.done) slots are counted of $1"
}
counted "$all"
end_daemon
mv data/three three.away
start
state stopped
counted $((all - $(grep -c '"type":"slot"' three.away/records.jsonl)))
mv three.away data/three
counted "$all"
end_daemon

# ---- its second disk is unplugged, and the mount point is a folder like any other: nothing is begun there, nor gone on with in the first ----
cp whole.yaml box.yaml
echo '  faults: [{kind: disk-full, at: 4s, for: 10h, amount: 100, target: first}]' >>box.yaml
start
plan fourth.yaml 'interval: 500ms' 'count: 4000' 'shot: {exposure: 10ms}' 'keep: raw' 'reserve: 100MiB' "storage: {second: $WORK/second}"
json_of fourth.yaml "$URL/plans/fourth" 200 -X PUT
post "$URL/run" 202 '{"plan":"fourth","dataset":"four"}'
heard 'the run goes on here' log 1 60
end_daemon
mv second second.disk
mkdir second
had=$(slots four)
start
state retrying
grep -q 'storage.second: the run went on in' out || fail "it does not say why: $(cat out)"
heard 'alarm text="the run went on in'
ask_status
is alarms.0.text "the run went on in $WORK/second/four from slot $had on, and nothing of it is there"
[ -z "$(ls -A second)" ] || fail "it began beneath the mount point"
[ "$(slots four)" = "$had" ] || fail "it went on in the first"
rmdir second
mv second.disk second
state capturing
ask_status
! grep -q 'went on in' out || fail "the alarm stands: $(cat out)"
get "$URL/run/stop" 202 "${ME[@]}" -X POST
state stopped
end_daemon
[ "$(slots four)" = "$had" ] || fail "it went on in the first"
expect 0 "$TTFBOX" verify second/four
rm -r data/four second/four
mv whole.yaml box.yaml

plan first.yaml 'interval: 500ms' 'count: 4' 'shot: {exposure: 10ms}' 'keep: both' 'reserve: 0B'
# ---- a port that is taken is said, and tried again; the box captures all the same ----
rm -rf data/* data/.ttfbox log
port=$("$PYTHON" -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
"$PYTHON" -c "
import socket, sys
s = socket.socket(); s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1); s.bind(('127.0.0.1', $port)); s.listen()
print('taken', flush=True); sys.stdin.read()" <held >taken &
exec 9>held
heard taken taken
sed -i "s/127.0.0.1:0/127.0.0.1:$port/; s/^data/plan: first.yaml\ndata/" ttfboxd.yaml
"$DAEMON" --config ttfboxd.yaml >log 2>&1 9>&- &
daemon=$!
heard "<4>unreachable at=\"127.0.0.1:$port\""
heard "<5>done slots=4 captured=4"
exec 9>&-
heard "listening at=\"127.0.0.1:$port\""
[ "$(grep -c unreachable log)" = 1 ] || fail "it says so again and again"
end_daemon
