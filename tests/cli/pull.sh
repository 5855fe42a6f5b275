#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Datasets brought from a box: whole, growing, cut off, damaged, from boxes that mean harm.
. "$(dirname "$0")/cli.bash"
. "$(dirname "$0")/server.bash"
CUTS=${TTFBOX_PULL_CUTS:-20}
SEED=${TTFBOX_PULL_SEED:-20261126}

plan p.yaml 'interval: 1h' 'count: 10' 'lamps: {mode: continuous}' 'shots:' \
    '  - {stream: main, channel: white, lamps: {left: 100%, right: 100%}, exposure: 20ms}' 'keep: both' 'mains: 50Hz'
mkdir data
expect 0 "$TTFBOX" capture p.yaml "${TINY[@]}" -o data/grass
expect 0 "$TTFBOX" note data/grass "watered" --slots 3
digest=$(sha256sum data/grass/SHA256SUMS | cut -c1-64)

# background COMMAND...: starts what says where it listens in its first line; WHERE and CHILD.
background() {
    : >where
    "$@" >where &
    CHILD=$!
    until [ -s where ]; do sleep 0.05; done
    WHERE=$(head -n 1 where)
}
# drop: ends it.
drop() {
    kill -KILL "$CHILD"
    wait "$CHILD" 2>/dev/null
}
# same A B: no file of the two differs.
same() { diff -r "$1" "$2" >differs || fail "$1 and $2 differ: $(head -n 3 differs)"; }

serve data
BOX=${URL%/api/v1}

# --- whole, and again at no cost
expect 0 "$TTFBOX" pull here --box "$BOX" --json
is sealed 1
is slots 10
same data here
expect 0 "$TTFBOX" pull here --box "$BOX" --json
is files 0
expect 0 "$TTFBOX" verify here/grass

# --- what was lost here comes again, and nothing else
rm here/grass/frames/main/000004.tif here/grass/SHA256SUMS
expect 0 "$TTFBOX" pull here --box "$BOX" --json
is files 1
same data here

# --- notes made here stay; those of the box come where there are none
echo '{"text":"mine"}' >here/grass/notes.jsonl
expect 0 "$TTFBOX" pull here --box "$BOX"
said err 'notes.jsonl here is not the box'
grep -q mine here/grass/notes.jsonl || fail "a note is gone"

# --- only what is named; what is not there
cp -r data/grass data/meadow
expect 0 "$TTFBOX" pull only --box "$BOX" --only meadow
if [ ! -d only/meadow ] || [ -e only/grass ]; then fail "another was brought than asked for"; fi
# Where nobody is, the address is named, not what was asked for.
expect 1 "$TTFBOX" pull only --box http://127.0.0.1:1
said err "http://127.0.0.1:1: the box does not answer"
said err "does ttfboxd or ttfbox serve run there?"
expect 2 "$TTFBOX" pull only --box "$BOX" --only nobody
said err 'no dataset of this name'
# Where reading is free a token is not needed, and none is wrong.
(umask 077 && echo not-the-token-of-this-box >wrong.token)
for _ in 1 2 3; do
    rm -rf unneeded
    expect 0 "$TTFBOX" pull unneeded --box "$BOX" --token-file wrong.token --only grass
done
expect 2 "$TTFBOX" pull only --box "$BOX" --only ../grass
rm -r data/meadow

# --- nothing of another is overwritten
mkdir -p taken/grass other
echo mine >taken/grass/thesis.txt
expect 2 "$TTFBOX" pull taken --box "$BOX"
said err 'is there, and no dataset'
[ "$(ls taken/grass)" = thesis.txt ] || fail "something was put into a folder of another"
expect 0 "$TTFBOX" capture p.yaml "${TINY[@]}" -o other/grass
cp -r other/grass before
expect 2 "$TTFBOX" pull other --box "$BOX"
said err 'another dataset'
same before other/grass

# --- growing: a dataset at every moment, the rest later
mv data/grass whole
cp -r whole data/grass
rm data/grass/SHA256SUMS
grow() { head -n "$1" whole/records.jsonl >data/grass/records.jsonl; }
grow 5
expect 0 "$TTFBOX" pull growing --box "$BOX" --json
is sealed 0
expect 0 "$TTFBOX" verify growing/grass
expect 0 "$TTFBOX" info growing/grass --json
seen=$(json slots)
grow 8
printf '{"type":"sl' >>data/grass/records.jsonl
expect 0 "$TTFBOX" pull growing --box "$BOX"
expect 0 "$TTFBOX" info growing/grass --json
is slots $((seen + 3))
expect 0 "$TTFBOX" verify growing/grass
# A line that was served and then lost by the box in a power cut is taken back.
grow 7
expect 0 "$TTFBOX" pull growing --box "$BOX"
cmp -s growing/grass/records.jsonl data/grass/records.jsonl || fail "a line that the box lost is still here"
# Events that the box has begun anew, fewer or others: they are its own to tell.
cat >events.py <<'EOF'
import json, sys, zlib
for length in sys.argv[2:]:
    body = json.dumps({"type": "event", "kind": sys.argv[1], "text": ""}, separators=(",", ":"))[:-2]
    body += "x" * (int(length) - len(body) - len('","crc":"00000000"}\n')) + '"'
    print('%s,"crc":"%08x"}' % (body, zlib.crc32(body.encode())))
EOF
many=$(printf '100 %.0s' {1..40})
for these in "door $many" 'door 100 100 100' 'door 100 200' 'lamp 300' "lamp $many" 'door 100 100' 'fan' 'fan 150 150' 'lamp 100 100 100'; do
    # shellcheck disable=SC2086 # words
    "$PYTHON" events.py $these >data/grass/events.jsonl
    expect 0 "$TTFBOX" pull growing --box "$BOX"
    cmp -s growing/grass/events.jsonl data/grass/events.jsonl || fail "events $these: those here are not the box's"
done
cp whole/events.jsonl data/grass/
# Half a line, and a file that a crash left in full length with other bytes: here.
printf '{"type":"half' >>growing/grass/records.jsonl
head -c "$(stat -c %s whole/frames/main/000007.tif)" /dev/zero >growing/grass/frames/main/000007.tif
grow 99
cp whole/SHA256SUMS data/grass/
expect 0 "$TTFBOX" pull growing --box "$BOX" --json
is sealed 1
same whole growing/grass
# Sealed here, gone on with there: the seal goes, and comes anew.
grow 9
rm data/grass/SHA256SUMS
cp -r growing sealed-then-not
sed -i '$d' sealed-then-not/grass/records.jsonl
rm sealed-then-not/grass/SHA256SUMS
expect 0 "$TTFBOX" pull sealed-then-not --box "$BOX" --json
is sealed 0
cp -r whole/. data/grass/

# --- damage on the box is named and left out, and comes when it is mended
printf X | dd of=data/grass/frames/main/000002.tif bs=1 seek=3000 conv=notrunc 2>/dev/null
rm data/grass/raw/main/000005.dng
expect 3 "$TTFBOX" pull damaged --box "$BOX"
said err 'grass/frames/main/000002.tif'
said err 'raw/main/000005.dng is missing on the box'
if [ -e damaged/grass/frames/main/000002.tif ] || [ ! -e damaged/grass/frames/main/000009.tif ]; then fail "not what was to come came"; fi
[ ! -e damaged/grass/SHA256SUMS ] || ! grep -q records.jsonl damaged/grass/SHA256SUMS || fail "it says that it is sealed"
cp -r whole/. data/grass/
expect 0 "$TTFBOX" pull damaged --box "$BOX" --json
is files 2
same whole damaged/grass

# --- what is rotten or gone on the box does not spoil what is here
cp -r damaged good
records=data/grass/records.jsonl
printf X | dd of=$records bs=1 seek=$(($(stat -c %s $records) - 40)) conv=notrunc 2>/dev/null
rm data/grass/SHA256SUMS
expect 3 "$TTFBOX" pull good --box "$BOX"
same whole good/grass
cp -r whole/. data/grass/
rm data/grass/events.jsonl data/grass/SHA256SUMS
expect 0 "$TTFBOX" pull good --box "$BOX"
said err 'events.jsonl is missing on the box'
expect 0 "$TTFBOX" verify good/grass
cmp -s good/grass/events.jsonl whole/events.jsonl || fail "the events here are gone"
cp -r whole/. data/grass/
# ... and what is rotten here is not taken for what the box lost.
rm good/grass/SHA256SUMS
printf X | dd of=good/grass/records.jsonl bs=1 seek=300 conv=notrunc 2>/dev/null
cp good/grass/records.jsonl rotten
expect 3 "$TTFBOX" pull good --box "$BOX"
said err 'a line here is damaged'
cmp -s rotten good/grass/records.jsonl || fail "lines here were cut off"

# --- a slot that the box lost before its disk had it, and recorded otherwise later: its images here go, too
mkdir -p lost
cp -r whole lost/grass
rm lost/grass/SHA256SUMS
head -n 6 whole/records.jsonl >data/grass/records.jsonl
last=$(tail -n 1 whole/records.jsonl | grep -c '"end"')
[ "$last" = 1 ] || fail "the last line is no end"
rm data/grass/SHA256SUMS data/grass/frames/main/00000[4-9].tif data/grass/raw/main/00000[4-9].dng
expect 0 "$TTFBOX" pull lost --box "$BOX"
expect 0 "$TTFBOX" verify lost/grass
[ -z "$(find lost/grass -name '000009.*')" ] || fail "images of a slot that is no more are still here"
cp -r whole/. data/grass/

# --- what the box's seal does not list would be damage beside it: a picture whose line the box lost, events of a box that has none
mkdir -p stray quiet/grass
cp -r whole stray/grass
rm stray/grass/SHA256SUMS
cp whole/frames/main/000003.tif stray/grass/frames/main/000123.tif
expect 0 "$TTFBOX" pull stray --box "$BOX" --json
is sealed 1
said err 'does not list (1) are NAME.tmp now'
expect 0 "$TTFBOX" verify stray/grass
[ -e stray/grass/frames/main/000123.tif.tmp ] || fail "what may be somebody's is gone"
rm data/grass/events.jsonl
sed -i '/  events.jsonl$/d' data/grass/SHA256SUMS
cp whole/dataset.json quiet/grass/
: >quiet/grass/events.jsonl
expect 0 "$TTFBOX" pull quiet --box "$BOX" --json
is sealed 1
expect 0 "$TTFBOX" verify quiet/grass
# ... and a seal that does not list what the records name, or of records without an end, is none.
cp whole/events.jsonl data/grass/
for without in frames/main/000004.tif dataset.json; do
    sed "\|  $without\$|d" whole/SHA256SUMS >data/grass/SHA256SUMS
    expect 3 "$TTFBOX" pull unlisted --box "$BOX"
    ! grep -qs records.jsonl unlisted/grass/SHA256SUMS || fail "a seal that does not list $without is here"
    expect 0 "$TTFBOX" verify unlisted/grass
done
sed -i '$d' data/grass/records.jsonl
sed "s/.*  records.jsonl\$/$(sha256sum data/grass/records.jsonl | cut -c1-64)  records.jsonl/" whole/SHA256SUMS >data/grass/SHA256SUMS
expect 3 "$TTFBOX" pull endless-records --box "$BOX"
expect 0 "$TTFBOX" verify endless-records/grass
cp -r whole/. data/grass/

# --- one that cannot be read does not keep the others from coming
mkdir data/broken
echo '{"format":' >data/broken/dataset.json
expect 2 "$TTFBOX" pull beside --box "$BOX" --only broken,grass
same whole beside/grass
rm -r data/broken

# --- followed: what is damaged there is no reason to go on for ever, nor is a box that is gone one to ask without a pause
printf X | dd of=data/grass/frames/main/000002.tif bs=1 seek=3000 conv=notrunc 2>/dev/null
expect 3 timeout 60 "$TTFBOX" pull followed --box "$BOX" --follow
cp -r whole/. data/grass/
timeout -s INT 4 "$TTFBOX" pull followed --box http://127.0.0.1:1 --follow >out 2>err
asked=$(grep -c 'does not answer' err)
if [ "$asked" -lt 1 ] || [ "$asked" -gt 4 ]; then fail "a box that is gone was asked $asked times in 4 s"; fi

# --- a box that is short of something says nothing of its file: it is asked again, and if it stays so, it is the box that is named
background "$PYTHON" "$HERE/short_box.py" "${BOX#http://}" frames/main/000004.tif 3
expect 0 "$TTFBOX" pull short --box "http://$WHERE"
said err 'the box says 503'
said err 'it is asked again'
same whole short/grass
drop
background "$PYTHON" "$HERE/short_box.py" "${BOX#http://}" frames/main/000004.tif 0
expect 1 "$TTFBOX" pull shorter --box "http://$WHERE"
said err 'the box says 503'
! grep -qi 'damaged' err || fail "a box that is short of something is called damaged"
[ -e shorter/grass/frames/main/000003.tif ] || fail "what came before is gone"
drop

# --- an answer that ends within its head is none, and no empty one: it is asked for again
for part in grass/files/dataset.json notes.jsonl grass/records SHA256SUMS frames/main/000004.tif; do
    for bytes in 10 40 300; do
        background "$PYTHON" "$HERE/one_answer.py" "${BOX#http://}" "$part" cut $bytes
        rm -rf headless
        expect 0 "$TTFBOX" pull headless --box "http://$WHERE" --json
        is damaged 0
        [ $bytes = 10 ] || said err 'does not answer' # of less than its first line libcurl asks again by itself
        same whole headless/grass
        drop
    done
done
# ... and a bit that turned over in what has no hash is seen, too: of what is new here, and of what is compared.
rm data/grass/SHA256SUMS
for part in grass/files/dataset.json notes.jsonl; do
    background "$PYTHON" "$HERE/one_answer.py" "${BOX#http://}" "$part" flip 20
    rm -rf bits
    expect 0 "$TTFBOX" pull bits --box "http://$WHERE"
    said err 'came in two ways'
    cmp -s "bits/grass/${part##*/}" "whole/${part##*/}" || fail "$part came with a wrong bit"
    drop
done
for part in grass/files/dataset.json grass/records; do
    background "$PYTHON" "$HERE/one_answer.py" "${BOX#http://}" "$part" flip 20
    expect 0 "$TTFBOX" pull bits --box "http://$WHERE"
    said err 'came in two ways'
    drop
done
cp -r whole/. data/grass/

# --- killed at random moments, and connections cut at random bytes
background "$PYTHON" "$HERE/bad_wire.py" "${BOX#http://}" "$SEED"
RANDOM=$SEED
for ((i = 0; i < CUTS; i++)); do
    "$TTFBOX" pull cut --box "http://$WHERE" >/dev/null 2>&1 &
    pid=$!
    sleep "0.0$((RANDOM % 90 + 10))"
    kill -KILL $pid 2>/dev/null
    wait $pid 2>/dev/null
    if [ -e cut/grass/dataset.json ]; then
        "$TTFBOX" verify cut/grass >out 2>err || [ ! -e cut/grass/records.jsonl ] || fail "after kill $i it is no whole dataset (seed $SEED)"
    fi
    [ $((i % 20)) -ne 19 ] || rm -rf cut
done
for ((i = 0; i < 200; i++)); do
    "$TTFBOX" pull cut --box "http://$WHERE" >out 2>err && break
done
[ "$i" -lt 200 ] || fail "it does not come through a wire that is cut (seed $SEED)"
same whole cut/grass
drop

# --- bits that turn over on the way
background "$PYTHON" "$HERE/bad_wire.py" "${BOX#http://}" "$SEED" flip
for ((i = 0; i < 50; i++)); do
    # A summary has no hash of its own: one whose "sealed" was turned over is believed, and says so.
    "$TTFBOX" pull flipped --box "http://$WHERE" >out 2>err && grep -q "1 of them sealed" out && break
    for f in flipped/grass/frames/main/*.tif flipped/grass/raw/main/*.dng; do
        [ ! -e "$f" ] || cmp -s "$f" "whole/${f#flipped/grass/}" || fail "$f came with a wrong bit (seed $SEED)"
    done
done
[ "$i" -lt 50 ] || fail "it does not come through a wire that turns bits over (seed $SEED)"
same whole flipped/grass
drop
unserve

# --- while it is captured, until it is sealed
plan live.yaml 'interval: 400ms' 'count: 15' 'shot: {exposure: 10ms}' 'keep: both'
rm -r data/grass
serve data
BOX=${URL%/api/v1}
"$TTFBOX" capture live.yaml "${TINY[@]}" --set sim.clock=real -o data/live >captured 2>&1 &
pid=$!
until [ -e data/live/dataset.json ]; do
    kill -0 $pid 2>/dev/null || fail "nothing is captured: $(cat captured)"
    sleep 0.05
done
expect 0 "$TTFBOX" pull live --box "$BOX" --follow --json
is sealed 1
wait $pid || fail "the capture failed: $(cat captured)"
same data/live live/live
unserve
expect 1 "$TTFBOX" pull live --box "$BOX"
said err 'does not answer'

# --- a wrong token is said to be that, however many came before
serve data --listen 0.0.0.0:0 --token-file token
BOX=${URL%/api/v1}
BOX=http://127.0.0.1:${BOX##*:}
expect 1 "$TTFBOX" pull refused --box "$BOX"
said err "give the box's token by --token-file"
for _ in $(seq 15); do
    expect 1 "$TTFBOX" pull refused --box "$BOX" --token-file wrong.token
    said err "the token that was given is not this box's"
done
said err "the box says 429"
expect 0 "$TTFBOX" pull granted --box "$BOX" --token-file token
unserve

# --- boxes that mean harm
for case in path absolute long garbage noend name size notes hidden nomanifest nolength; do
    background "$PYTHON" "$HERE/evil_box.py" $case
    timeout 60 "$TTFBOX" pull "evil-$case/in/here" --box "http://$WHERE" >out 2>err
    code=$?
    [ $code -le 3 ] || fail "$case: exit $code"
    for place in escaped /tmp/escaped "evil-$case/escaped" "evil-$case/in/escaped"; do
        [ ! -e "$place" ] || fail "$case: it wrote $place"
    done
    for place in notes.jsonl .envrc; do
        [ ! -e "evil-$case/in/here/grass/$place" ] || fail "$case: it wrote $place"
    done
    # Without a manifest it is not known whose place it would take; nor with one that may be a part of itself.
    [ $case != nolength ] || said err 'without a length'
    if [[ $case = no[ml]* ]] && { [ $code = 0 ] || [ -e "evil-$case/in/here/grass" ]; }; then fail "$case: exit $code, and something was written"; fi
    [ $code = 3 ] || [ $case = name ] || [ $case = noend ] || [[ $case = no[ml]* ]] || fail "$case: exit $code instead of 3"
    [ -z "$(find "evil-$case" -size +100k)" ] || fail "$case: it took more than was said"
    drop
done
# Records without end that name no file fill the disk, and no memory.
background "$PYTHON" "$HERE/evil_box.py" endless
"$PYTHON" -c 'import resource, subprocess, sys
subprocess.run(sys.argv[1:], check=False, timeout=60)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)' "$TTFBOX" pull endless --box "http://$WHERE" -q >out 2>err
[ "$(stat -c %s endless/grass/records.jsonl)" -gt 70000000 ] || fail "the endless records end soon"
sanitized "$TTFBOX" || [ "$(tail -n 1 out)" -lt 65536 ] || fail "lines that name no files take $(tail -n 1 out) kB of memory"
drop
[ "$digest" = "$(sha256sum whole/SHA256SUMS | cut -c1-64)" ] || fail "the test spoilt its own dataset"

expect 2 "$TTFBOX" pull here
said err '--box'
expect 2 "$TTFBOX" pull here --box ftp://box
said err 'is no box'
