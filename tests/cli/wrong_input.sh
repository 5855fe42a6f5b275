#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What is wrong is refused with exit code 2, the place and what was meant; damaged
# data with 3; nothing is overwritten.
. "$(dirname "$0")/cli.bash"

# ---- eight kinds of wrong plan: file:line, what was meant, exit 2 ----
wrong_plan() { # WHERE WORDS LINES...
    local where=$1 words=$2
    shift 2
    plan wrong.yaml "$@"
    for command in "plan check" "capture -o never"; do
        # shellcheck disable=SC2086
        expect 2 "$TTFBOX" $command wrong.yaml
        said err "wrong.yaml:$where"
        said err "$words"
    done
    expect 2 "$TTFBOX" plan check wrong.yaml --json
    is exit 2
    json where | grep -q "wrong.yaml:$where" || fail "where in JSON"
    [ -e never ] && fail "a wrong plan made a dataset"
}
wrong_plan 1:11 "write 10s" "interval: 10" "count: 5"
wrong_plan 3:22 "write 20s, 20ms or 20min" "interval: 10min" "count: 5" "shots: [{ exposure:  20 }]"
wrong_plan 3:46 "write 80%, or 0.8% if" "interval: 10min" "count: 5" "lamps: {mode: continuous, day_levels: {left: 0.8}}"
wrong_plan 3:1 "did you mean 'interval'" "interval: 10min" "count: 5" "intervall: 3min"
wrong_plan 1:11 "out of its range" "interval: -10min" "count: 5"
wrong_plan 1:11 "'nan' is not a time" "interval: nan" "count: 5"
wrong_plan 2:8 "far too large" "interval: 10min" "count: 123456789012345678901234567890"
wrong_plan 1:1 "the file is empty" ""
wrong_plan 2: "this is not YAML" "interval: 10min" " count: [5"
plan wrong.yaml "interval: 10min" "count: 1008" "lamps: {mode: continuous}" \
    "shots: [{exposure: 20ms, lamps: {left: 100%}}]"
expect 2 "$TTFBOX" plan check wrong.yaml --set lamps.left.max_duty=10% --set lamps.left.duty_window=24h
said err "wrong.yaml:"
said err "'left'"
said err "of 24 h; the board allows 10.0 %"
expect 2 "$TTFBOX" plan check wrong.yaml --set lamps.left.max_on=12h
said err "at a stretch; the board allows 12 h"
expect 2 "$TTFBOX" capture wrong.yaml -o never --set lamps.left.max_duty=10% --set lamps.left.duty_window=24h
said err "wrong.yaml:"
[ -e never ] && fail "a plan beyond a lamp's duty made a dataset"

# ---- plans that no box or disk can hold, with the best there is ----
plan fast.yaml "interval: 100ms" "count: 10" "shot: {exposure: 90ms, average: 4}"
expect 2 "$TTFBOX" plan check fast.yaml
said err "fast.yaml:1:11: interval"
plan huge.yaml "interval: 10min" "count: 1000000" "keep: both" "reserve: 900TB"
expect 2 "$TTFBOX" plan check huge.yaml -o here/later
said err "huge.yaml:2:8: count: here/later"

# ---- options ----
plan ok.yaml "interval: 10min" "count: 3"
expect 2 "$TTFBOX" plan check
expect 2 "$TTFBOX" plan check ok.yaml extra
expect 2 "$TTFBOX" plan check nowhere.yaml
said err "nowhere.yaml"
expect 2 "$TTFBOX" plan check .
expect 2 "$TTFBOX" plan check ok.yaml --board nonsense
said err "nonsense: there is no such board"
grep -qF "$SOURCE" "$WORK/err" && fail "a path of whoever built the program"
expect 2 "$TTFBOX" plan check ok.yaml --set sim.sed=5
said err "did you mean 'seed'?"
expect 2 "$TTFBOX" plan check ok.yaml --set sim.seed
expect 2 "$TTFBOX" plan check ok.yaml --scene gras
expect 2 "$TTFBOX" plan check ok.yaml --scene ./nowhere
expect 2 "$TTFBOX" capture ok.yaml
said err "-o: is missing"
expect 2 "$TTFBOX" capture ok.yaml -o d --threads many
said err "--threads"
expect 2 "$TTFBOX" capture ok.yaml -o d --rehearse 0
expect 2 "$TTFBOX" capture ok.yaml -o "bad name"
expect 2 "$TTFBOX" calibrate dark
expect 2 "$TTFBOX" calibrate flat "${TINY[@]}" -o cal
said err "--scene white"
expect 2 "$TTFBOX" calibrate report nowhere
expect 2 "$TTFBOX" import -o d
expect 2 "$TTFBOX" import nothing.png -o d --interval 1min
expect 2 "$TTFBOX" import ok.yaml -o d --interval 1min
expect 2 "$TTFBOX" import in.png -o "a b" --interval 1min
said err "a b: is no name of a dataset"
said err "A-Z a-z 0-9 . _ and -"
grep -q part- "$WORK/err" && fail "an internal name"
expect 2 "$TTFBOX" info nowhere
expect 2 "$TTFBOX" info .
expect 2 "$TTFBOX" verify nowhere
expect 2 "$TTFBOX" export nowhere -o x.mp4
expect 2 "$TTFBOX" synth quilt nowhere -o q
expect 2 "$TTFBOX" develop nowhere -o q

# ---- with a dataset at hand ----
expect 0 "$TTFBOX" capture ok.yaml "${TINY[@]}" -o d
expect 2 "$TTFBOX" export d -o x.xyz
said err "--to"
expect 2 "$TTFBOX" export d -o x --to mpeg
expect 2 "$TTFBOX" export d -o x.mp4 --gaps fill
expect 2 "$TTFBOX" export d -o x.png --stream other
expect 2 "$TTFBOX" synth quilt d -o q --block 640x480
expect 2 "$TTFBOX" synth quilt d -o q --size 0x5
expect 2 "$TTFBOX" synth quilt d -o q --metric odd
expect 2 "$TTFBOX" synth quilt d -o q --sink tape
expect 2 "$TTFBOX" synth quilt d -o q --compress lzma
expect 2 "$TTFBOX" synth quilt d -o q --sink raw --check
[ -e q ] && fail "a refused synthesis left something"

# ---- a start that has passed by the box's clock: nothing would begin in time ----
plan past.yaml "interval: 10min" "count: 3" "start: 2025-12-31T23:00:00Z"
for command in "plan check" "capture -o never" ; do
    # shellcheck disable=SC2086
    expect 2 "$TTFBOX" $command past.yaml "${TINY[@]}"
    said err "past.yaml:3:8: start"
    said err "the box's clock says 2026-03-01T08:00"
done
[ -e never ] && fail "a start in the past made a dataset"
plan soon.yaml "interval: 10min" "count: 3" "start: 2026-03-01T09:00:00Z"
expect 0 "$TTFBOX" plan check soon.yaml "${TINY[@]}"
expect 0 "$TTFBOX" capture soon.yaml "${TINY[@]}" -o soon --json
is captured 3
is already_complete false
expect 0 "$TTFBOX" capture soon.yaml "${TINY[@]}" -o soon --json
is already_complete true
expect 0 "$TTFBOX" capture soon.yaml "${TINY[@]}" -o soon
said out "complete          already"
grep -q timing "$WORK/out" && fail "the timing of nothing"

# ---- nothing is written into a dataset, by whatever way the path leads there ----
digest=$(sha256sum d/SHA256SUMS)
mkdir elsewhere && ln -s ../d elsewhere/link
for there in d/in d/frames/main/in d/new/in ./d//in/ elsewhere/link/in elsewhere/../d/in; do
    expect 2 "$TTFBOX" synth quilt d --block 16x16 --size 64x64 -o "$there"
    said err "inside of the dataset"
    expect 2 "$TTFBOX" capture ok.yaml "${TINY[@]}" -o "$there"
    said err "inside of the dataset"
done
(cd d && expect 2 "$TTFBOX" export . --to sheet -o in.png && said err "inside of the dataset") || exit 1
expect 2 "$TTFBOX" export d -o d/in.npy
said err "inside of the dataset"
expect 2 "$TTFBOX" develop d -o d/in
said err "inside of the dataset"
expect 2 "$TTFBOX" import in.png --interval 1min -o d/in
said err "inside of the dataset"
expect 2 "$TTFBOX" calibrate dark "${TINY[@]}" -o d/in
said err "inside of the dataset"
[ "$digest" = "$(sha256sum d/SHA256SUMS)" ] || fail "the seal changed"
expect 0 "$TTFBOX" verify d

# ---- nothing is overwritten ----
mkdir full && echo mine >full/file && echo mine >file
for there in full file; do
    expect 2 "$TTFBOX" capture ok.yaml "${TINY[@]}" -o $there
    said err "is there already"
    expect 2 "$TTFBOX" synth quilt d --block 16x16 -o $there
    said err "exists already"
    expect 2 "$TTFBOX" develop d -o $there
    expect 2 "$TTFBOX" calibrate dark "${TINY[@]}" -o $there
    expect 2 "$TTFBOX" export d --to png -o $there
done
echo mine >a.npy.json && mkdir -p a.y4m.json/mine
expect 2 "$TTFBOX" export d -o a.npy
said err "a.npy.json: exists already"
expect 2 "$TTFBOX" export d -o a.y4m
said err "a.y4m.json: exists already"
[ -e a.npy ] || [ -e a.y4m ] && fail "exported without a sidecar"
expect 0 "$TTFBOX" export d --to sheet -o a.npy # which has no sidecar
rm a.npy
[ "$(cat full/file file a.npy.json)" = "$(printf 'mine\nmine\nmine')" ] || fail "something was overwritten"
expect 0 "$TTFBOX" synth quilt d --block 16x16 --size 64x64 -o q
expect 2 "$TTFBOX" capture ok.yaml "${TINY[@]}" -o q
said err "no capture"

# ---- a full disk: which, why, and what to do; nothing half done stays ----
full() { # KIB COMMAND...: on a disk of that size at small/; its exit code, 7 if it fits, 8 if it fails and leaves something
    # shellcheck disable=SC2016 # the inner shell's
    unshare -rm sh -c 'mount -t tmpfs -o size=$1k tmpfs small || exit 9
        shift
        "$@"
        r=$?
        [ $r = 0 ] && exit 7
        [ -z "$(ls -A small)" ] || { ls -AR small; exit 8; }
        exit $r' sh "$@"
}
plan raw.yaml "interval: 10min" "count: 3" "keep: raw"
expect 0 "$TTFBOX" capture raw.yaml "${TINY[@]}" -o r
mkdir small
if unshare -rm mount -t tmpfs tmpfs small 2>/dev/null; then
    expect 0 "$TTFBOX" export d --to png -o pictures
    for command in "export d --to png" "export d --to npy" "export d --to y4m" "export d --to sheet" "synth quilt d --block 16x16" "develop r" "import pictures/*.png --interval 1s"; do
        for size in 8 20 40; do # in the middle of a frame, or before there is a dataset
            # shellcheck disable=SC2086
            full $size "$TTFBOX" $command -o small/it >out 2>err
            code=$?
            [ $code = 7 ] && continue # it fits
            [ $code = 1 ] || fail "exit $code instead of 1: $command, $size KiB: $(cat err)"
            said err "small/it"
            said err "No space left on device"
            grep -q part- err && fail "an internal name: $(cat err)"
        done
    done
else
    echo "no file system of one's own can be mounted here: a full disk was not tried"
fi

# ---- damage is named by file and slot, exit 3 ----
cp -r d hurt
frame=$(cd hurt && ls frames/main/000001*.tif)
printf 'X' | dd of="hurt/$frame" bs=1 seek=2000 conv=notrunc 2>/dev/null
expect 3 "$TTFBOX" verify hurt
said out "DAMAGED"
said out "$frame, slot 1"
expect 3 "$TTFBOX" verify hurt --json
is damaged true
is findings.0.slot 1
rm "hurt/$frame"
expect 3 "$TTFBOX" verify hurt
said out "$frame"
cp -r d torn
sed -i '0,/"captured"/s//"captureD"/' torn/records.jsonl
expect 3 "$TTFBOX" verify torn
expect 3 "$TTFBOX" info torn
expect 3 "$TTFBOX" capture ok.yaml "${TINY[@]}" -o torn
echo "wrong input: all refused, nothing overwritten"
