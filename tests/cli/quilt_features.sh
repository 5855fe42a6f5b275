#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What quilting can do beside quilting: each option once, by what it changes.
. "$(dirname "$0")/cli.bash"

frames() {
    "$PYTHON" "$HERE/frames.py" "$@" || fail "frames.py $*"
}

# holds EXPRESSION: a comparison that awk finds true.
holds() {
    awk "BEGIN { exit !($1) }" || fail "it is not so that $1"
}

# quilt NAME OPTIONS...: a small raw result NAME.rgb of d, its JSON in out.
quilt() {
    local name=$1
    shift
    rm -f "$name.rgb"
    expect 0 "$TTFBOX" synth quilt d --size 96x64 --block 16x16 --sink raw -o "$name.rgb" --json "$@"
}

mkdir in
"$PYTHON" "$HERE/pictures.py" make in 16 60 48 || fail "making pictures"
expect 0 "$TTFBOX" import in/*.png --interval 1min -o d
expect 0 "$TTFBOX" import in/p[0-9].png --interval 1min -o d10 # its first ten

# ---- a raw file is what an export of the dataset shows, by both ways there ----
for how in "" "--jitter 2"; do
    # shellcheck disable=SC2086
    quilt plain $how
    is report.measured false
    [ "$(stat -c %s plain.rgb)" = $((16 * 96 * 64 * 3)) ] || fail "the raw file's size"
    rm -rf q png
    # shellcheck disable=SC2086
    expect 0 "$TTFBOX" synth quilt d --size 96x64 --block 16x16 -o q --json $how
    is report.measured true
    expect 0 "$TTFBOX" export q --to png -o png
    frames pngs png png.rgb
    cmp plain.rgb png.rgb || fail "raw and exported bytes differ ($how)"
done
quilt plain --figures
is report.measured true
[ "$(json report.memory_bytes.peak_resident)" -gt 1000000 ] || fail "no peak of memory"
rm -rf q && expect 0 "$TTFBOX" synth quilt d --size 96x64 --block 16x16 -o q --no-figures --json
is report.measured false
said q/report.json '"measured": false'

# ---- a raw file has its name when it is whole, and not before ----
"$TTFBOX" synth quilt d --size 1500x1500 --block 16x16 --sink raw -o killed.rgb -q &
child=$!
for _ in $(seq 1000); do
    parts=(.killed.rgb.part-*)
    [ -e "${parts[0]}" ] && break
    sleep 0.01
done
[ -e "${parts[0]}" ] || fail "nothing was begun"
kill -KILL $child
wait $child && fail "it was whole before it could be killed"
[ ! -e killed.rgb ] || fail "a file that is not whole has its name"
rm "${parts[0]}"
mkdir taken
expect 2 "$TTFBOX" synth quilt d --block 16x16 --sink raw -o taken
[ -z "$(ls -A taken)" ] || fail "something was left in the folder"

# Of a still, and of what never changes, there is no share of a change: neither 0 nor any other number.
expect 0 "$TTFBOX" synth quilt in/p0.png --size 96x64 --block 16x16 --sink null --figures --json
is report.temporal_coherence.difference_ratio None
is report.temporal_coherence.second_difference_ratio None
expect 0 "$TTFBOX" synth quilt in/p0.png --size 96x64 --block 16x16 --sink null --figures
said out "nothing to compare: the input is one frame"
mkdir same && for i in 0 1 2 3; do cp in/p0.png same/p$i.png; done
expect 0 "$TTFBOX" import same/*.png --interval 1min -o same-d
expect 0 "$TTFBOX" synth quilt same-d --size 96x64 --block 16x16 -o q2 --check
said out "nothing to compare: the input does not change, the output by 0.00 codes a frame"
said out "all copied, bit for bit"
grep -q "^flicker" out && fail "a flicker of what never changes"

# ---- blocks and matching ----
rm -f auto.rgb && expect 0 "$TTFBOX" synth quilt d --block auto --sink raw -o auto.rgb --json
is report.prepared.block_from_features true
holds "$(json report.prepared.correlation_x_px) > 0"
holds "$(json report.parameters.block.0) >= 16"
quilt other --rank 4
is report.compression.rank 4
quilt other --rank full
is report.compression.rank full
quilt other --rank-error 5
holds "$(json report.compression.error) <= 0.05 && $(json report.compression.rank) > 1"
quilt other --svd channels
is report.compression.of "each channel"
quilt other --agreement 1000
is report.agreement_with_full_time_search.queries $(($(json report.blocks.count) - 1))
quilt other --avoid 12
spread=$(json report.repetition.source_coverage)
quilt plain
holds "$spread > $(json report.repetition.source_coverage)"
quilt other --tileable
is report.parameters.tileable true
holds "$(frames edges other.rgb 96 64) * 1.5 < $(frames edges plain.rgb 96 64)"
quilt other --source d --flips --rotations --save-map all.json
is report.parameters.inputs 2
uuid=$(json report.sources.1.uuid)
said d/dataset.json "$uuid"
is report.sources.1.digest "$(sha256sum d/SHA256SUMS | cut -d' ' -f1)"
"$PYTHON" -c 'import json
blocks = json.load(open("all.json"))["blocks"]
assert {b["input"] for b in blocks} == {0, 1} and len({b["turn"] for b in blocks}) > 3' ||
    fail "no blocks of other inputs and turns"

# ---- maps: the same again, and of another sequence of the same size ----
quilt plain --save-map map.json
expect 0 "$TTFBOX" synth quilt d --map map.json --sink raw -o again.rgb --json
is report.parameters.replayed true
cmp plain.rgb again.rgb || fail "a replayed map gives another output"
quilt jittered --jitter 2 --feather 3 --tileable --save-map jittered.json
rm again.rgb && expect 0 "$TTFBOX" synth quilt d --map jittered.json --sink raw -o again.rgb --json
cmp jittered.rgb again.rgb || fail "a replayed map forgets feather or times"
cmp -s jittered.rgb plain.rgb && fail "jitter and feather change nothing"
rm again.rgb && expect 0 "$TTFBOX" synth quilt d10 --map map.json --sink raw -o again.rgb
cmp -n $((10 * 96 * 64 * 3)) plain.rgb again.rgb || fail "a map on another dataset"
quilt rounded --jitter 2 --jitter-rounded --save-map rounded.json
is report.parameters.jitter rounded
again() { # NAME OPTIONS...: the map NAME.json lays what NAME.rgb is
    local name=$1
    shift
    rm -f again.rgb && expect 0 "$TTFBOX" synth quilt d --map "$name.json" --sink raw -o again.rgb --json "$@"
    cmp "$name.rgb" again.rgb || fail "the map $name.json lays something else"
}
again rounded
is report.parameters.jitter rounded
quilt jittered --jitter 2
cmp -s rounded.rgb jittered.rgb && fail "rounding changes nothing"

# A map goes at the pace of the output that it was saved with, and another control takes its place.
frames picture halves halves.png 96 64
quilt paced --rate-map halves.png --rate-offset 0.25 --rate-gain 0.3 --save-map paced.json
frames=$(json report.output_frames)
[ "$frames" -gt 16 ] || fail "it is not slowed: $frames frames"
again paced
is report.output_frames "$frames"
is report.parameters.rate_map true
expect 0 "$TTFBOX" synth quilt d --map paced.json --rate-map halves.png --sink null --json
is report.output_frames 16
expect 2 "$TTFBOX" synth quilt d --map paced.json --check -o never
said err "--check: the map gives pixels a pace of their own"
# Light that is taken out is told from what is seen by the block: the map's, not the default.
quilt evened --flatten --save-map evened.json
again evened --flatten

# Nothing is said of a search that never was: neither seed nor tolerance, nor errors of other frames.
quilt found --seed 9 --mirror --avoid 4 --tolerance 0.3 --save-map found.json
error=$(json report.blocks.mean_rms_error)
holds "$error > 0"
rm -rf q3 && expect 0 "$TTFBOX" synth quilt d10 --map found.json -o q3 --json
is report.blocks.mean_rms_error "$error"
for what in seed tolerance metric mirror flips rotations avoid_px; do
    is report.parameters.$what None
done
is report.parameters.block.0 16
is report.compression.error None
grep -q "\"derived_from\"" q3/dataset.json || fail "it is derived of nothing"
grep -q '"seed"' q3/dataset.json && fail "a seed that nothing was picked by: $(grep '"seed"' q3/dataset.json)"
rm -rf q3 && expect 0 "$TTFBOX" synth quilt d10 --map found.json -o q3
said out "16 x 16, replayed"
grep -q "seed" out && fail "a seed of a replay: $(grep seed out)"

# ---- factors: a grown dataset goes on ----
rm -f f10.rgb && expect 0 "$TTFBOX" synth quilt d10 --block 16x16 --sink raw -o f10.rgb --factors f --json
is report.compression.frames_known_before 0
quilt other --factors f
is report.compression.frames_known_before 10
quilt other --factors f
is report.compression.frames_known_before 16
sum=$(sha256sum f)
expect 2 "$TTFBOX" synth quilt d10 --block 16x16 --sink raw -o never --factors f
said err "--factors: they are of 16 frames"
expect 2 "$TTFBOX" synth quilt d --block 16x16 --sink raw -o never --factors map.json
said err "--factors"
[ "$sum" = "$(sha256sum f)" ] || fail "factors of another length were overwritten"
[ "$(head -c 1 map.json)" = "{" ] || fail "a file of others was overwritten"

# ---- preparation ----
quilt flat --flatten --save-map flat.json
is report.prepared.gradient_removed true
is report.prepared.gradient_applied_again false
holds "$(json report.prepared.gradient_most) > 1.1"
quilt kept --flatten --keep-gradient
is report.prepared.gradient_applied_again true
holds "$(frames slope flat.rgb 96 64) < 12"
holds "$(frames slope kept.rgb 96 64) > 25"
quilt other --flatten --flatten-sigma 4
cmp -s other.rgb flat.rgb && fail "--flatten-sigma changes nothing"
mkdir nudged && frames nudged nudged 12 64 48
expect 0 "$TTFBOX" import nudged/*.png --interval 1min -o n
expect 0 "$TTFBOX" synth quilt n --block 16x16 --sink null --stabilise --deflicker --deflicker-window 5 --json
is report.prepared.stabilised true
is report.prepared.frames_moved 2
holds "$(json report.prepared.largest_shift_px) > 1.5 && $(json report.prepared.cropped_px.0) >= 2"
is report.prepared.deflickered true
holds "$(json report.prepared.flicker_after) * 3 < $(json report.prepared.flicker_before)"
is report.prepared.frames_unlike 0
# What is often is told by the pixels of all inputs, not of the first: here one spot is laid 112 times instead of 8.
mkdir other-in && frames nudged other-in 16 64 48
expect 0 "$TTFBOX" import other-in/*.png --interval 1min -o other-d
expect 0 "$TTFBOX" synth quilt d --source other-d --seed 3 --size 240x192 --block 12x12 --sink null --figures
said out "the same place again and again"
# Of several inputs each has its own: this one's neighbour stands still.
mkdir calm && for i in $(seq 10 21); do cp "$(compgen -G 'nudged/*.png' | head -n 1)" "calm/p$i.png"; done
expect 0 "$TTFBOX" import calm/*.png --interval 1min -o calm-d
expect 0 "$TTFBOX" synth quilt n --source calm-d --block 16x16 --sink null --stabilise --json
is report.prepared.frames_moved 2
is report.sources.0.prepared.frames_moved 2
is report.sources.1.prepared.frames_moved 0
expect 0 "$TTFBOX" synth quilt n --source calm-d --block 16x16 --sink null --stabilise
said out "stabilised        2 frames moved"
said out "stabilised        input 2: 0 frames moved"

# ---- control: dark places lag, and the output is as long as its fastest pixel takes ----
frames picture hill hill.png 96 64
frames picture tilt tilt.png 96 64
quilt lag --rate-map halves.png
is report.parameters.rate_map true
is report.output_frames 16
holds "$(frames moved lag.rgb 96 64 0 40) == 0"
holds "$(frames moved lag.rgb 96 64 56 96) > 5"
rm -rf slow && expect 0 "$TTFBOX" synth quilt d --size 96x64 --block 16x16 -o slow --rate-map halves.png \
    --rate-offset 0.25 --rate-gain 0.25 --json
is report.output_frames 31
expect 0 "$TTFBOX" verify slow
grep -q '"index":30,.*"due_ns":1800000000000\b' slow/records.jsonl || fail "the times do not go on"
quilt lit --light 0.5,0.3,0.4
for how in "--normals tilt.png" "--heights hill.png" "--heights hill.png --height-scale 0.5" "--rate-gain 0.5"; do
    # shellcheck disable=SC2086
    quilt other --light 0.5,0.3,0.4 $how
    cmp -s lit.rgb other.rgb && fail "$how changes nothing"
done
printf '# a bend\n-2, 4\n-1, 1\n0,0\n\n1,1\n2,4\n' >bend.csv
quilt sigmoid --curvature sigmoid
for what in bend.csv hill.png; do
    quilt other --curvature $what
    is report.parameters.rate_map true
    cmp -s sigmoid.rgb other.rgb && fail "--curvature $what is no other"
done

# ---- previews stay within what they were given ----
rm -rf q && expect 0 "$TTFBOX" synth quilt d --size 720x576 --block 16x16 --preview --memory 24MiB -o q --json
is report.prepared.reduced true
shrunk=$(json preview.shrunk_by)
[ "$shrunk" -ge 2 ] || fail "the preview is no smaller"
is report.parameters.size.0 $((720 / shrunk))
peak=$(json report.memory_bytes.peak_resident)
[ "$peak" -le $((24 << 20)) ] || fail "a preview within 24 MiB took $peak bytes"
[ "$(json preview.estimated_bytes)" -le $((24 << 20)) ] || fail "the preview's own estimate"
rm -rf q && expect 0 "$TTFBOX" synth quilt d --block 16x16 --size 480x360 --preview --time 100ms -o q
said out "shrunk by"
said out "of 0.1"
expect 2 "$TTFBOX" synth quilt d --block 16x16 --preview --memory 1MiB -o never
said err "--memory: no preview"
expect 2 "$TTFBOX" synth quilt d --block 16x16 --rank 64 --memory 1MiB -o never
said err "1 MiB are allowed"

# ---- ranks ----
expect 0 "$TTFBOX" synth rank d -o curve.csv --json
[ "$(wc -l <curve.csv)" = 66 ] || fail "65 ranks and a head"
"$PYTHON" -c 'import csv, xml.dom.minidom
rows = list(csv.DictReader(open("curve.csv")))
errors = [float(r["error"]) for r in rows]
assert errors[0] == 1 and errors == sorted(errors, reverse=True) and errors[1] > errors[15] > errors[40]
assert all(float(r["rms_over_full_scale"]) < 1 for r in rows)
svg = xml.dom.minidom.parse("curve.svg")
assert len(svg.getElementsByTagName("polyline")[0].getAttribute("points").split()) == 64
texts = [t.firstChild.data for t in svg.getElementsByTagName("text")]
assert "rank k" in texts and "error" in texts and any("%" in t for t in texts), texts' || fail "table or plot"
quilt other --rank 15
error=$(json report.compression.error)
expect 0 "$TTFBOX" synth rank d --rank 15 --svd joint -o short.csv
holds "($error - $(sed -n '17s/[^,]*,\([^,]*\),.*/\1/p' short.csv)) ^ 2 < 1e-12"
expect 0 "$TTFBOX" synth rank d --svd channels --frames 8 -o channels.csv
cmp -s curve.csv channels.csv && fail "--svd changes nothing"
cp curve.csv before.csv
expect 2 "$TTFBOX" synth rank d -o curve.csv
expect 2 "$TTFBOX" synth rank d -o curve
said err "curve.svg"
expect 2 "$TTFBOX" synth rank d -o never.svg
expect 2 "$TTFBOX" synth rank d --rank full -o never.csv
expect 2 "$TTFBOX" synth rank d --svd some -o never.csv
expect 2 "$TTFBOX" synth rank nowhere -o never.csv
cmp curve.csv before.csv || fail "a table was overwritten"

# ---- an object and its shadow over a growing texture ----
frames picture photo photo.png 80 64
frames picture plain plain.png 80 64
expect 0 "$TTFBOX" synth composite photo.png d --block 16x16 --sink raw -o comp.rgb --json
is report.parameters.rate_map true
holds "$(json object_share) > 0.05 && $(json object_share) < 0.08"
for t in 0 15; do # the object lies there at all times
    read -r r g b <<<"$(frames mean comp.rgb 80 64 30 24 3 $t)"
    holds "$r > 160 && $g < 60 && $b < 60"
done
read -r _ dark _ <<<"$(frames mean comp.rgb 80 64 40 40 5 0)"
read -r _ light _ <<<"$(frames mean comp.rgb 80 64 70 40 5 0)"
[ $((dark * 10)) -lt $((light * 7)) ] || fail "no shadow: $dark, $light"
expect 0 "$TTFBOX" synth composite photo.png d --block 16x16 -o comp --size 40x32 --least 1 --threshold 0.2 --soften 0 --json
is report.parameters.size.0 40
is report.output_frames 16
expect 0 "$TTFBOX" verify comp
expect 0 "$TTFBOX" synth composite photo.png d --block 16x16 --sink null --jitter-rounded --preview --json
is report.parameters.size.0 80
expect 0 "$TTFBOX" info comp
expect 2 "$TTFBOX" synth composite plain.png d --block 16x16 -o never
said err "plain.png"
expect 2 "$TTFBOX" synth composite d photo.png --block 16x16 -o never
expect 2 "$TTFBOX" synth composite nowhere.png d --block 16x16 -o never

for left in never never.csv never.svg; do
    [ -e $left ] && fail "a refused synthesis left something"
done
echo "quilt features: each does what it says"
