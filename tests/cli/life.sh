#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# One dataset's whole life: calibrate, capture, verify, info, develop, export, synthesize.
. "$(dirname "$0")/cli.bash"

# The plans that the documents show all fit their boards.
for sample in "$PLANS"/*.yaml; do
    board=sim
    case ${sample##*/} in demo.yaml | bench-synth.yaml) board=sim-small ;; esac
    expect 0 "$TTFBOX" plan check "$sample" --board "$board"
    said out "The plan fits."
done
expect 0 "$TTFBOX" plan check "$PLANS/fast.yaml" --board "$SOURCE/boards/sim/real-clock.yaml"

plan week.yaml "title: A week" "interval: 6h" "until: 7d" "lamps: {mode: capture-only, settle: 20s}" \
    "shots: [{lamps: {left: 100%, right: 100%}, exposure: 20ms}]" \
    "region: {x: 8, y: 8, width: 80, height: 48}" "keep: both"

expect 0 "$TTFBOX" plan check week.yaml "${TINY[@]}" -o grass
said out "SIMULATED"
said out "28, one every 6 h"
said out "write speed"
expect 0 "$TTFBOX" plan check week.yaml "${TINY[@]}" --json
is slots 28
is simulated true
is lamps.1.switchings 28
[ -e grass ] && fail "plan check left something behind"

expect 0 "$TTFBOX" board probe "${TINY[@]}"
said out "SIMULATED"
said out "96 x 64, mosaic RGGB of 12 bits"
said out "gain 1.00 to 16.00"
said out "lens: not a plan's"
expect 0 "$TTFBOX" board probe "${TINY[@]}" --json
is silent 0
is cameras.0.width 96
is cameras.0.gain_max_milli 16000
is cameras.0.lens false
expect 0 "$TTFBOX" board probe "${TINY[@]}" --set watchdog=none --set panel=none --json
is watchdog false
expect 1 "$TTFBOX" board probe "${TINY[@]}" --set 'sim.faults=[{kind: sensor-gone, at: 0s, for: 1h, target: box-temp}]'
said out "DOES NOT ANSWER"

expect 0 "$TTFBOX" calibrate dark "${TINY[@]}" --plan week.yaml --frames 16 -o cal
expect 2 "$TTFBOX" calibrate dark "${TINY[@]}" --plan week.yaml --frames 16 -o cal
said err "holds a dark already"
expect 0 "$TTFBOX" calibrate flat "${TINY[@]}" --plan week.yaml --frames 16 --scene white -o cal
expect 0 "$TTFBOX" calibrate report cal --json
is has_dark true
is has_flat true
is simulated true

expect 0 "$TTFBOX" capture week.yaml "${TINY[@]}" -c cal --rehearse 3 -o try
said out "headroom"
said out "sustains"
expect 0 "$TTFBOX" info try --json
is sealed false
is slots 3

expect 0 "$TTFBOX" capture week.yaml "${TINY[@]}" -c cal -o grass
said out "SIMULATED"
said out "28 captured"
[ -s "$WORK/err" ] && fail "a capture without trouble says something on standard error"
expect 0 "$TTFBOX" capture week.yaml "${TINY[@]}" -c cal -o again --json --threads 1
is captured 28
is simulated true
is sealed true
for frame in 000000 000013 000027; do
    cmp "grass/frames/main/$frame.tif" "again/frames/main/$frame.tif" ||
        fail "frame $frame differs between two runs of the same seed"
done
expect 0 "$TTFBOX" capture week.yaml "${TINY[@]}" -c cal --seed 2 -o other --json
cmp -s grass/frames/main/000013.tif other/frames/main/000013.tif && fail "the seed has no effect"
expect 0 "$TTFBOX" capture week.yaml "${TINY[@]}" -c cal -o grass --json
is sealed true
is slots 28

expect 0 "$TTFBOX" verify grass
said out "SIMULATED"
said out "whole: 28 slots"
(cd grass && sha256sum --strict --quiet -c SHA256SUMS) || fail "sha256sum says otherwise"
expect 0 "$TTFBOX" verify grass --json
is damage 0
is leftover 0
digest=$(json digest)
[ "$digest" = "$(sha256sum grass/SHA256SUMS | cut -d' ' -f1)" ] || fail "the digest is another"

expect 0 "$TTFBOX" info grass
said out "SIMULATED"
expect 0 "$TTFBOX" info grass --json
is simulated true
is slots 28
is captured 28
is streams.0.width 80
is streams.0.primary true
is digest "$digest"
is interval_ns 21600000000000

# The same raw frames and calibration give the same bits; no calibration gives others.
expect 0 "$TTFBOX" develop grass -c cal -o grass2 --json
is images 28
for frame in 000000 000013 000027; do
    cmp "grass/frames/main/$frame.tif" "grass2/frames/main/$frame.tif" ||
        fail "developing anew gives other bits"
done
expect 0 "$TTFBOX" verify grass2
expect 0 "$TTFBOX" info grass2 --json
is derived_digest "$digest"
expect 0 "$TTFBOX" develop grass -o grass3 --frames 2 --json
is images 2

# What the values mean is said by the calibration they were developed with.
expect 0 "$TTFBOX" calibrate dark "${TINY[@]}" --plan week.yaml --frames 4 -o dark
expect 0 "$TTFBOX" develop grass -c dark -o grass4 --frames 2
expect 0 "$TTFBOX" info grass4 --json
is streams.0.quantity radiance
plan bare.yaml "interval: 6h" "count: 2" "lamps: {mode: capture-only, settle: 20s}" \
    "shots: [{lamps: {left: 100%, right: 100%}, exposure: 20ms, brackets: [0.3, 1]}]" "keep: raw"
expect 0 "$TTFBOX" plan check bare.yaml "${TINY[@]}"
said out "20.000 ms, brackets of 0.3, 1"
expect 0 "$TTFBOX" capture bare.yaml "${TINY[@]}" -o bare
# 6 ms are no whole half-period of the mains: 10 ms were granted, and the record says so.
grep -q '"relative_exposure":0.5}' bare/records.jsonl || fail "a bracket is not recorded as granted"
expect 0 "$TTFBOX" capture bare.yaml "${TINY[@]}" -o bare
grep -q timing "$WORK/out" && fail "figures of a run that captured nothing"
expect 0 "$TTFBOX" develop bare -c cal -o lit
expect 0 "$TTFBOX" info lit --json
is streams.0.quantity reflectance

expect 0 "$TTFBOX" export grass --to sheet -o sheet.png
expect 0 "$TTFBOX" export grass --to png --frames 5 -o pngs --json
is frames 5
for n in 1001 1002 1003 1004 1005; do
    [ -s pngs/frame.$n.png ] || fail "numbering: $(ls pngs)"
done
expect 0 "$TTFBOX" export grass --to tiff --name blade --start 1 --every 7 -o tiffs
[ -e tiffs/blade.0001.tif ] || [ -e tiffs/blade.1.tif ] || fail "names: $(ls tiffs)"
expect 0 "$TTFBOX" export grass -o grass.npy --json
is frames 28
expect 0 "$TTFBOX" export grass -o grass.y4m
head -c 9 grass.y4m | grep -q YUV4MPEG2 || fail "no y4m"
if command -v ffmpeg >/dev/null; then
    expect 0 "$TTFBOX" export grass -o grass.mp4 --width 64
    [ -s grass.mp4 ] || fail "an empty video"
else
    echo "ffmpeg is not installed: mp4 was not tried"
fi

expect 0 "$TTFBOX" synth quilt grass --size 128x96 --block 24x32 --seed 5 --check -o meadow
said out "SIMULATED"
said out "all copied, bit for bit"
expect 0 "$TTFBOX" verify meadow
expect 0 "$TTFBOX" info meadow --json
is derived_digest "$digest"
is streams.0.width 128
[ -s meadow/report.json ] || fail "no report"
expect 0 "$TTFBOX" synth quilt grass --size 128x96 --block 24x32 --seed 5 -o meadow2 --threads 1 --compress deflate --json
cmp meadow/frames/main/000003.tif meadow2/frames/main/000003.tif >/dev/null &&
    fail "--compress deflate compresses nothing"
expect 0 "$TTFBOX" export meadow -o m1.npy
expect 0 "$TTFBOX" export meadow2 -o m2.npy
cmp m1.npy m2.npy || fail "threads or compression change the result"
expect 0 "$TTFBOX" synth quilt grass --size 128x96 --block 24x32 --seed 5 --frames 4 --sink raw -o four.rgb
[ "$(stat -c %s four.rgb)" = $((4 * 128 * 96 * 3)) ] || fail "the raw file's size"
expect 0 "$TTFBOX" synth quilt grass --block 24x32 --sink null --json
is report.frames 28
expect 0 "$TTFBOX" synth quilt sheet.png --block 32x32 --size 300x200 --check -o still --json
is unmatched_pixels 0

# Three shots a slot: two lamp states and a bracket.
sed 's/^region:.*//' "$PLANS/three-shots.yaml" >three.yaml
expect 0 "$TTFBOX" capture three.yaml "${TINY[@]}" -o three --json
is captured 12
expect 0 "$TTFBOX" verify three
expect 0 "$TTFBOX" info three --json
[ "$(json streams | grep -o "'id'" | wc -l)" = 3 ] || fail "not three streams"
[ "$(find three/raw/main -type f | wc -l)" = 36 ] || fail "not three brackets a slot"
expect 0 "$TTFBOX" export three --stream raking-left --to sheet -o raking.png
echo "life: one dataset from calibration to synthesis"
