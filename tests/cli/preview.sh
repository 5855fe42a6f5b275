#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ttfbox-preview: a preview that follows a dataset, killed at any moment, and nothing of the dataset touched.
. "$(dirname "$0")/cli.bash"
. "$HERE/server.bash"
process=
trap '[ -z "$process" ] || kill -9 $process 2>/dev/null; rm -rf "$WORK"' EXIT
SMALL=(--board sim-small --set sim.sensor.width=96px --set sim.sensor.height=64px)

plan grass.yaml 'interval: 10s' 'count: 240' 'shot: {exposure: 10ms}'
"$TTFBOX" capture grass.yaml "${SMALL[@]}" -o whole -q >/dev/null || fail "no capture"
capture() { # SLOTS: the dataset as it is after so many
    "$PYTHON" "$HERE/grow.py" whole data/grass "$1" || fail "it does not grow"
}
refresh() { # [OPTIONS...]
    expect 0 "$PREVIEW" --folder data --ttfbox "$TTFBOX" --room 1MB --time 2s --eager --once "$@"
}
state() { # KEY: of the state, as the server gives it
    get "$URL/datasets/grass/preview" 200
    json "$1"
}
frames_are_there() { # all that the state names, and each a JPEG
    "$PYTHON" - data/.preview/grass <<'CHECK' || fail "the state names what is not there: $(cat data/.preview/grass/state.json)"
import json, os, sys
state = json.load(open(sys.argv[1] + "/state.json"))
for frame in state["frames"]:
    assert open(f"{sys.argv[1]}/{frame['path']}", "rb").read(2) == b"\xff\xd8", frame
assert state["state"] == "failed" or len(state["frames"]) > 1, state
CHECK
}

synthesizing() { # ids of syntheses that run in this folder
    "$PYTHON" -c 'import os, sys
for pid in filter(str.isdigit, os.listdir("/proc")):
    try:
        if os.readlink(f"/proc/{pid}/cwd") == sys.argv[1] and b"synth\0quilt" in open(f"/proc/{pid}/cmdline", "rb").read():
            print(pid)
    except OSError:
        pass' "$WORK"
}

expect 2 "$PREVIEW"
said err "--folder or --config is missing"
expect 2 "$PREVIEW" --folder data --every soon
expect 0 "$PREVIEW" --help
said out "--memory"

# ---- too few images: nothing yet ----
mkdir data
capture 5
serve data
refresh
[ "$(state state)" = none ] || fail "a preview of five images"

# ---- a preview; asked for by HTTP; the dataset is as it was ----
capture 12
before=$(cd data/grass && find . -type f -exec sha256sum {} + | sort)
refresh
frames_are_there
[ "$(state state)" = ready ] || fail "no preview: $(cat err)"
is images 12
is frames.0.slot 0
is frames.11.slot 11
get "$URL/datasets/grass/preview/$(json frames.3.path)" 200
[ "$(head -c 2 out | od -An -tx1 | tr -d ' ')" = ffd8 ] || fail "no JPEG"
for wrong in state.json ../state.json ../../grass/dataset.json factors g1; do
    get "$URL/datasets/grass/preview/$wrong" 404 --path-as-is
done
# ---- the same as a video: one that players open, any part of it ----
"$PYTHON" - "$URL/datasets/grass" "$(command -v ffprobe)" <<'CHECK' || fail "the video is none: $(cat out)"
import json, struct, subprocess, sys, urllib.request
url, ffprobe = sys.argv[1:]
def get(path, **headers):
    with urllib.request.urlopen(urllib.request.Request(url + path, headers=headers)) as answer:
        return answer.status, answer.headers, answer.read()
state = json.loads(get("/preview")[2])
frames = [get("/preview/" + frame["path"])[2] for frame in state["frames"]]
status, headers, video = get("/preview.avi")
assert headers["Content-Type"] == "video/x-msvideo" and int(headers["Content-Length"]) == len(video), headers
assert headers["Content-Disposition"].endswith('"grass-preview.avi"'), headers
assert video[:4] == b"RIFF" and struct.unpack("<I", video[4:8])[0] == len(video) - 8 and video[8:12] == b"AVI ", video[:12]
movi = video.index(b"movi")
index = video.rindex(b"idx1")
entries = [struct.unpack("<4sIII", video[at:at + 16]) for at in range(index + 8, len(video), 16)]
assert len(entries) == len(frames) > 1, (len(entries), len(frames))
for (tag, _, at, size), frame in zip(entries, frames):
    assert video[movi + at:movi + at + 4] == tag == b"00dc" and video[movi + at + 8:movi + at + 8 + size] == frame, "a frame of the video is another"
for first, last in ((0, 99), (200, 4000), (len(video) // 2, len(video) - 1), (len(video) - 5, len(video) - 1)):
    status, _, part = get("/preview.avi", Range=f"bytes={first}-{last}")
    assert status == 206 and part == video[first:min(last, len(video) - 1) + 1], (first, last)
open("grass.avi", "wb").write(video)
if ffprobe:
    got = json.loads(subprocess.check_output([ffprobe, "-v", "error", "-count_frames", "-show_streams", "-of", "json", "grass.avi"], stderr=subprocess.STDOUT))["streams"][0]
    assert (got["codec_name"], got["width"], got["height"]) == ("mjpeg", state["width"], state["height"]), got
    assert int(got["nb_read_frames"]) == len(frames) and got["r_frame_rate"] == "8/1", got
CHECK
get "$URL/datasets/none-such/preview.avi" 404

# as many and as large as frames may be: no AVI has room for that, and none is begun
mv data/.preview/grass/state.json state.json
truncate -s 16M data/.preview/grass/large.jpg
"$PYTHON" - "$URL/datasets/grass/preview.avi" <<'LARGE' || fail "a video of 4 GiB was begun"
import json, sys, urllib.request
state = json.load(open("state.json"))
state["frames"] = [dict(state["frames"][0], path="large.jpg")] * 256
with open("data/.preview/grass/state.json", "w") as file:
    json.dump(state, file)
try:
    urllib.request.urlopen(urllib.request.Request(sys.argv[1], headers={"Range": "bytes=0-9"}))
    sys.exit(1)
except urllib.error.HTTPError as error:
    assert error.code == 400, error
LARGE
rm data/.preview/grass/large.jpg
mv state.json data/.preview/grass/state.json

[ "$(cd data/grass && find . -type f -exec sha256sum {} + | sort)" = "$before" ] || fail "the dataset was touched"
expect 0 "$TTFBOX" verify data/grass

# ---- nothing new, nothing done; it grows, the preview follows, and only new frames are compressed ----
made=$(state made_utc_ns)
refresh
[ "$(state made_utc_ns)" = "$made" ] || fail "made anew without need"
[ -s data/.preview/grass/factors ] || fail "no factors are kept"
capture 30
refresh
[ "$(state images)" = 30 ] || fail "it does not follow"
is generation 2
frames_are_there
[ -e data/.preview/grass/g1 ] || fail "the generation before is gone at once"

# ---- one at a time ----
"$PREVIEW" --folder data --ttfbox "$TTFBOX" --room 1MB --every 100ms 2>log &
process=$!
for _ in $(seq 200); do [ "$("$PYTHON" -c 'import fcntl,sys
try: fcntl.flock(open("data/.preview/lock"), fcntl.LOCK_SH | fcntl.LOCK_NB); print("free")
except OSError: print("held")' 2>/dev/null)" = held ] && break; sleep 0.05; done
expect 1 "$PREVIEW" --folder data --once
said err "another process makes previews"

# ---- it is the last in everything ----
"$PYTHON" -c 'import os,sys
pid = int(sys.argv[1])
assert os.getpriority(os.PRIO_PROCESS, pid) == 19, os.getpriority(os.PRIO_PROCESS, pid)
assert os.sched_getscheduler(pid) == os.SCHED_IDLE, os.sched_getscheduler(pid)' $process || fail "it is not the last in everything"
grep -q "Max address space *[0-9]" "/proc/$process/limits" || fail "its memory is not limited"
kill -9 $process
wait $process 2>/dev/null

# ---- a newest folder that is no dataset any more does not keep it from the others, and is told of once ----
mkdir -p data/broken
echo '{"format":' >data/broken/dataset.json
touch -d tomorrow data/broken/records.jsonl

# ---- it follows by itself; killed again and again, what is in force is whole, and no child goes on ----
"$PREVIEW" --folder data --ttfbox "$TTFBOX" --room 1MB --every 100ms --eager 2>>log &
process=$!
capture 60
for _ in $(seq 200); do
    grep -q '"images":60' data/.preview/grass/state.json && break
    sleep 0.05
done
frames_are_there
[ "$(state images)" = 60 ] || fail "it does not follow by itself: $(cat log)"
for i in $(seq 5); do
    kill -9 $process
    wait $process 2>/dev/null
    frames_are_there
    alone=$(synthesizing)
    [ -z "$alone" ] || { sleep 1; alone=$(synthesizing); }
    [ -z "$alone" ] || fail "the synthesis goes on alone: $alone"
    capture $((60 + i * 12))
    "$PREVIEW" --folder data --ttfbox "$TTFBOX" --room 1MB --every 100ms --eager 2>>log &
    process=$!
    sleep "0.$((i * 13 % 10))$((i * 7 % 10))"
done
for _ in $(seq 400); do
    grep -q '"images":120' data/.preview/grass/state.json && break
    sleep 0.05
done
frames_are_there
[ "$(state images)" = 120 ] || fail "after the kills it does not go on: $(tail -5 log)"
kill -TERM $process
wait $process || fail "told to end it ended with $?"
[ -e data/.preview/grass/making ] && fail "something half-made is left"
ls data/.preview/grass/*.tmp 2>/dev/null && fail "a .tmp is left"

told=$(grep -c 'passed over' log)
if [ "$told" -lt 1 ] || [ "$told" -gt 6 ]; then fail "$told times it said of one folder, at six starts, that it is passed over"; fi
rm -r data/broken

# ---- a synthesis that fails: said, and what was there stays ----
capture 200
expect 0 "$PREVIEW" --folder data --ttfbox /bin/false --room 1MB --eager --once
[ "$(state state)" = failed ] || fail "the failure is not said"
is why "the synthesis ended with 1"
frames_are_there
refresh --ttfbox "$TTFBOX" # not tried again with the same images
[ "$(state state)" = failed ] || fail "tried again although nothing is new"

# ---- of a dataset that has ended the last one is tried again, later; what belonged to datasets that are gone goes ----
mkdir data/.preview/gone data/.preview/gone/g1
touch -d tomorrow whole/records.jsonl
mv whole data/ended
expect 0 "$PREVIEW" --folder data --ttfbox /bin/false --room 1MB --eager --once
[ ! -e data/.preview/gone ] || fail "the cache of a dataset that is gone stays"
grep -q '"state":"failed".*"tries":1' data/.preview/ended/state.json || fail "the failure is not said"
[ ! -e data/.preview/ended/making ] || fail "what was half made stays"
refresh --every 1h
grep -q '"state":"failed"' data/.preview/ended/state.json || fail "tried again at once"
refresh --every 1ms --room 200MB
grep -q '"state":"ready".*"images":240' data/.preview/ended/state.json || fail "not tried again: $(cat data/.preview/ended/state.json)"
mv data/ended whole
refresh --every 1ms # another dataset is the newest: this one's goes
[ ! -e data/.preview/ended ] || fail "the cache of a dataset that was moved away stays"

# ---- no room: nothing is done ----
capture 240
refresh --room 1000TB
[ "$(state images)" = 120 ] || fail "it works where there is no room"

# ---- another dataset of the same name has no preview yet ----
frame=$(state frames.0.path)
get "$URL/datasets/grass/preview/$frame" 200
rm -rf data/grass
"$TTFBOX" capture grass.yaml "${SMALL[@]}" -o whole2 -q >/dev/null || fail "no second capture"
"$PYTHON" "$HERE/grow.py" whole2 data/grass 12 || fail "it does not grow"
[ "$(state state)" = none ] || fail "the preview of the dataset before is shown as this one's"
get "$URL/datasets/grass/preview/$frame" 404
get "$URL/datasets/grass/preview.avi" 404
refresh
[ "$(state images)" = 12 ] || fail "the preview is of the dataset before"
is generation 1
expect 0 "$TTFBOX" verify data/grass

# ---- of raw frames alone there can be none: that is said, and not tried ----
plan raw.yaml 'interval: 10s' 'count: 12' 'shot: {exposure: 10ms}' 'keep: raw'
"$TTFBOX" capture raw.yaml "${SMALL[@]}" -o data/raw -q >/dev/null || fail "no capture of raw frames"
touch -d tomorrow data/raw/records.jsonl
refresh --ttfbox "$PWD/none-such"
get "$URL/datasets/raw/preview" 200
is state failed
is why "only raw frames: develop the dataset first"
is tried_images 0
unserve
