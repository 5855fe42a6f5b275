#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ttfboxd while its disk, a small one of its own, fills up: previews go first, then slots are missed; nothing committed is lost, and it goes on.
[ -n "${DAEMON:-}" ] || exit 77 # built without a box
# A disk of some MiB is a mount, in a name space of this script alone: of root's, or of a user name space.
if [ -z "${INSIDE:-}" ]; then
    for way in "unshare -m" "unshare -rm"; do
        # shellcheck disable=SC2086 # a command and its option
        $way sh -c 'mount -t tmpfs -o size=64k none /mnt' 2>/dev/null && INSIDE=1 exec $way bash "$0"
    done
    echo "skipped: neither root nor a user name space may mount a small disk here"
    exit 77
fi
. "$(dirname "$0")/cli.bash"
. "$(dirname "$0")/bench.bash"
. "$(dirname "$0")/server.bash"
. "$(dirname "$0")/daemon.bash"

bench_box
mkdir data
mount -t tmpfs -o size=24m none data || fail "no small disk"
trap 'kill -9 "$daemon" 2>/dev/null; wait; cd /; umount "$WORK/data"; rm -rf "$WORK"' EXIT
daemon=
plan grass.yaml 'interval: 400ms' 'count: 200' 'shot: {exposure: 10ms}' 'keep: both' 'reserve: 4MiB'
printf 'board: ./box.yaml\nplan: grass.yaml\ndata: data\nretry: 300ms\nlisten: ["127.0.0.1:0"]\n' >ttfboxd.yaml

start() {
    : >log
    begin_daemon
    daemon_url
    ME=(-H "Authorization: Bearer $(cat data/.ttfbox/token)")
}
status() { get "$URL/status" 200 "${ME[@]}"; }
until_is() { # CONDITION: of the status, in Python, within 15 s
    for _ in $(seq 300); do
        status
        "$PYTHON" -I -S -c 'import json
s = json.load(open("out", encoding="utf-8"))
run = s.get("run", {})
n = run.get("results", {})
alarms = [a["text"] for a in s.get("alarms", [])]
raise SystemExit(not ('"$1"'))' && return 0
        sleep 0.05
    done
    fail "not so: $1: $(cat out) $(cat log)"
}
free_kib() { df --output=avail -k data | tail -n 1; }
leave() { # KIB: fills the disk so far
    head -c "$((($(free_kib) - $1) * 1024))" /dev/zero >data/ballast."$1"
}
committed() { # the files of slots, with their hashes
    (cd data/grass && find frames raw -type f ! -name '*.tmp' -exec sha256sum {} +) | sort -k 2
}

# ---- a little above the reserve: previews go, the oldest first, and no more of them than are in the way ----
start
until_is 'n.get("captured", 0) >= 3'
mkdir -p data/grass/preview/main
for k in 0 1 2 3 4 5 6 7; do
    head -c 512K /dev/zero >data/grass/preview/main/00000$k.jpg
done
leave 4200
for _ in $(seq 300); do
    [ -e data/grass/preview/main/000000.jpg ] || break
    sleep 0.05
done
[ ! -e data/grass/preview/main/000000.jpg ] || fail "the oldest preview stays: $(cat log)"
[ -e data/grass/preview/main/000007.jpg ] || fail "more previews went than there was need for"
status
seen=$(json run.results.captured)
until_is 'n.get("captured", 0) >= '$((seen + 3))' and not alarms'
grep -q '"kind":"disk".*files of preview/ were removed to make room' data/grass/events.jsonl || fail "no event of it"

# ---- less than the reserve and no preview left: slots are missed, by record; a person is called ----
leave 500
until_is 'n.get("missed", 0) >= 3 and s["state"] == "capturing" and run["last"]["why"] == "disk full"'
until_is 'any("disk full" in a for a in alarms) and s["disk"]["free_bytes"] < 4 << 20'
[ -z "$(ls data/grass/preview/main)" ] || fail "slots are missed, and previews stay"
committed >before
[ -s before ] || fail "nothing was captured"

# ---- not a byte left: its records wait in memory, and whoever asks is answered ----
leave 0
[ "$(free_kib)" -eq 0 ] || fail "there is room: $(free_kib) KiB"
sleep 2
committed | cmp -s - before || fail "a slot was captured on the reserve"
until_is 's["state"] == "capturing" and s["disk"]["free_bytes"] == 0 and alarms'
get "$URL/datasets/grass" 200 "${ME[@]}"
is sealed false

# What is sent now is refused, and no half of it stays.
sed 's/^board: .*/board: mine/' box.yaml >mine.yaml
send() { # STATUS
    get "$URL/boards/mine" "$1" "${ME[@]}" -H 'Content-Type: application/yaml' -X PUT --data-binary @mine.yaml
}
send 500
grep -q 'No space left on device' out || fail "it does not say why: $(cat out)"
get "$URL/boards/mine" 404 "${ME[@]}"
[ -z "$(find data/.ttfbox/boards -type f)" ] || fail "half of it stays: $(find data/.ttfbox)"

# ---- killed there it begins anew: the line that says so finds room in a block of its file, and records wait for theirs, or it is tried again ----
end_daemon KILL
start
until_is 's["disk"]["free_bytes"] == 0 and (s["state"] == "retrying" and "No space left on device" in s["why"]
    or s["state"] == "capturing" and any("disk full" in a for a in alarms))'
committed | cmp -s - before || fail "files of committed slots changed: $(committed | diff before -)"
expect 0 "$TTFBOX" verify data/grass

# ---- room is made: it goes on by itself, and every slot has its record ----
seen=$(grep -c '"result":"captured"' data/grass/records.jsonl)
rm data/ballast.*
until_is 's["state"] == "capturing" and n.get("captured", 0) >= '$((seen + 3))' and not alarms'
send 200
end_daemon
expect 0 "$TTFBOX" verify data/grass --json
(cd data/grass && sha256sum --quiet -c) <before || fail "what was committed is not there any more"
"$PYTHON" -I -S - data/grass/records.jsonl <<'END' || fail "records are lacking"
import json, sys
from collections import Counter
index, said = [], Counter()
for line in open(sys.argv[1], encoding="utf-8"):
    record = json.loads(line)
    if record["type"] == "slot":
        index.append(record["index"])
        said[record["result"], record.get("reason", "")] += 1
assert index == list(range(len(index))), index
assert said["missed", "disk full"] >= 3, said
assert {result for result, _ in said} <= {"captured", "missed", "power"}, said
END
echo "daemon_full: all as it should be"
