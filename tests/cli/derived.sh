#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What a server derives from datasets for a page: columns for charts, small pictures.
. "$(dirname "$0")/cli.bash"
. "$HERE/server.bash"

mkdir data
plan grass.yaml 'interval: 10s' 'count: 12' 'shot: {exposure: 10ms}'
"$TTFBOX" capture grass.yaml "${TINY[@]}" -o data/grass -q || fail "no capture"
serve data

# ---- charts: a column for each thing that records say, over all slots ----
get "$URL/datasets/grass/charts" 200
"$PYTHON" - out data/grass <<'CHECK' || fail "the columns are not the records'"
import json, math, sys
charts = json.load(open(sys.argv[1]))
records = [json.loads(line) for line in open(sys.argv[2] + "/records.jsonl")]
slots = [r for r in records if r["type"] == "slot"]
segment = next(r for r in records if r["type"] == "segment")
assert charts["complete"] is True and charts["slots"] == 12 and charts["slots_per_point"] == 1, charts
assert charts["index"] == [s["index"] for s in slots]
assert charts["due_utc_ns"] == [segment["origin_utc_ns"] + s["due_ns"] - segment["origin_ns"] for s in slots]
assert charts["results"]["captured"] == [1] * 12 and charts["results"]["missed"] == [0] * 12
by = {(s["what"], s.get("name", s.get("stream"))): s for s in charts["series"]}
mean = by[("mean_level", "main")]
assert mean["min"] == mean["max"] == [s["images"][0]["mean_level"] for s in slots], mean
error = by[("slot_error_s", None)]
assert all(math.isclose(e, (s["middle_ns"] - s["due_ns"]) / 1e9, abs_tol=1e-12) for e, s in zip(error["mean"], slots))
for name in {s["name"] for r in slots for s in r.get("sensors", [])}:
    column = by[("sensor", name)]
    assert column["max"] == [next(s["value"] for s in r["sensors"] if s["name"] == name) for r in slots], column
CHECK
tag=$(grep -i '^etag:' headers | tr -d '\r' | sed 's/^[^ ]* //')
get "$URL/datasets/grass/charts" 304 -H "If-None-Match: $tag"

# A dataset that grows is read on, not anew; one that was replaced is another.
get "$URL/datasets/nowhere/charts" 404
sed -i 's/count: 12/count: 15/' grass.yaml
"$TTFBOX" capture grass.yaml "${TINY[@]}" -o data/grass -q || fail "it does not go on"
get "$URL/datasets/grass/charts" 200 -H "If-None-Match: $tag"
is slots 15
is index.14 14
rm -rf data/grass
plan grass.yaml 'interval: 5s' 'count: 3' 'shot: {exposure: 10ms}'
"$TTFBOX" capture grass.yaml "${TINY[@]}" -o data/grass -q || fail "no second capture"
get "$URL/datasets/grass/charts" 200
is slots 3

# ---- small pictures ----
mkdir -p data/grass/preview/main
get "$URL/datasets/grass/thumbs/1" 200
[ "$(head -c 3 out | od -An -tx1 | tr -d ' ')" = ffd8ff ] || fail "no JPEG"
grep -qi '^content-type: image/jpeg' headers || fail "it does not say that it is a JPEG"
cp out made.jpg
tag=$(grep -i '^etag:' headers | tr -d '\r' | sed 's/^[^ ]* //')
get "$URL/datasets/grass/thumbs/1" 304 -H "If-None-Match: $tag"
get "$URL/datasets/grass/thumbs/1" 200
cmp -s out made.jpg || fail "it is another picture the second time"
get "$URL/datasets/grass/thumbs/000001" 200
# What is asked for again and again takes one place among those that are remembered: the others stay.
image=data/grass/frames/main/000001.tif
cp $image image.kept
"$PYTHON" - "${URL#http://}" <<'CHECK' || fail "a small picture is not given again and again"
import http.client, sys
connection = http.client.HTTPConnection(sys.argv[1].split("/")[0], timeout=30)
for _ in range(1100):
    connection.request("GET", "/api/v1/datasets/grass/thumbs/0")
    answer = connection.getresponse()
    answer.read()
    assert answer.status == 200, answer.status
CHECK
printf 'no picture' >$image
get "$URL/datasets/grass/thumbs/1" 200
cmp -s out made.jpg || fail "another picture that was asked for often has driven it out"
cp image.kept $image
for wrong in 3 x -1 1.5 1x 99999999999999999999 1/2; do
    get "$URL/datasets/grass/thumbs/$wrong" 404
done
printf 'the own' >data/grass/preview/main/000002.jpg
get "$URL/datasets/grass/thumbs/2" 200
[ "$(cat out)" = "the own" ] || fail "the dataset's own preview is passed over"
plan raw.yaml 'interval: 5s' 'count: 2' 'shot: {exposure: 10ms}' 'keep: raw'
"$TTFBOX" capture raw.yaml "${TINY[@]}" -o data/raw -q || fail "no capture of raw images"
get "$URL/datasets/raw/thumbs/0" 200
[ "$(head -c 3 out | od -An -tx1 | tr -d ' ')" = ffd8ff ] || fail "no JPEG of a raw image"
rm data/raw/raw/main/000001.dng
get "$URL/datasets/raw/thumbs/1" 404

# ---- the summary of a dataset that grows says at each moment what reading all of it says ----
"$TTFBOX" capture grass.yaml "${TINY[@]}" -o whole -q || fail "no capture"
for n in 0 1 2 3; do
    "$PYTHON" "$HERE/grow.py" whole data/growing "$n" || fail "it does not grow"
    get "$URL/datasets/growing" 200
    is slots "$n"
    is results.captured "$n"
    is segments 1
    is sealed false
    is ended false
done
printf '{"type":"slot","seq":99' >>data/growing/records.jsonl # as a power cut leaves it
get "$URL/datasets/growing" 200
is slots 3
cp whole/records.jsonl data/growing/records.jsonl # another file, and the end
get "$URL/datasets/growing" 200
is ended true
sed -i '3s/"index":./"index":9/' data/growing/records.jsonl # rot
get "$URL/datasets/growing" 500
said out "damaged"

# 12,000 slots: at most 1,024 points, by parts, and no slot is lost on the way.
"$PYTHON" "$HERE/many_slots.py" data/grass data/many 12000 || fail "they cannot be made"
# Of a slot far from the beginning nothing is known at first: who asks for its picture asks again, and holds nobody up.
get "$URL/datasets/many/thumbs/11999" 503
said out "ask again"
asked=0
while :; do
    get "$URL/datasets/many/charts" 200
    asked=$((asked + 1))
    [ "$(json complete)" = true ] && break
    [ $asked -lt 50 ] || fail "it never comes to an end"
done
[ $asked -gt 1 ] || fail "12,000 records were read at one request"
is slots 12000
"$PYTHON" - out <<'CHECK' || fail "the points are wrong"
import json, sys
c = json.load(open(sys.argv[1]))
assert 500 < len(c["index"]) <= 1024 and c["slots_per_point"] == 16, (len(c["index"]), c["slots_per_point"])
assert sum(c["results"]["captured"]) == 12000
spiked = next(s for s in c["series"] if s["what"] == "mean_level")
assert max(spiked["max"]) == 0.875, max(spiked["max"])
CHECK

# A slot that was missed has no picture, which is nothing wrong; one that there is not is.
"$PYTHON" "$HERE/many_slots.py" data/grass data/gaps 40 --files --missed 3 || fail "they cannot be made"
get "$URL/datasets/gaps/thumbs/16" 204
[ ! -s out ] || fail "of none something is sent"
grep -qiE '^(Content-Type|ETag):' headers && fail "none has a type, or a tag"
get "$URL/datasets/gaps/thumbs/19" 200
get "$URL/datasets/gaps/thumbs/40" 404

# ---- at most eight archives at once; one that ends makes room ----
"$PYTHON" - "${URL#http://}" <<'CHECK' || fail "archives are not bounded"
import http.client, sys, time
host = sys.argv[1].split("/")[0]
def ask():
    connection = http.client.HTTPConnection(host, timeout=30)
    connection.request("GET", "/api/v1/datasets/large/tar")
    return connection, connection.getresponse()
import os
os.makedirs("data/large/frames", exist_ok=True)
open("data/large/dataset.json", "w").write("{}")
with open("data/large/frames/hole.tif", "wb") as file:
    file.truncate(1 << 30) # more than sockets hold
held = [ask() for _ in range(8)]
assert all(answer.status == 200 for _, answer in held), [answer.status for _, answer in held]
_, ninth = ask()
assert ninth.status == 503, ninth.status
held.pop()[0].close()
for _ in range(100):
    again, answer = ask()
    if answer.status == 200:
        break
    time.sleep(0.1)
assert answer.status == 200, answer.status
CHECK
unserve

# ---- the limit of open files is raised; where it cannot be, the server still serves ----
(ulimit -Sn 64; serve data; grep "Max open files" "/proc/$SERVER/limits" >limits; unserve) || fail "not with few files"
[ "$(awk '{ print $4 }' limits)" -gt 64 ] || fail "the limit of open files stays: $(cat limits)"
(ulimit -n 200; serve data; get "$URL/datasets/grass" 200; unserve) || fail "not with 200 files"
