#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What a dataset that was developed anew takes over of the one it was made of: what people said of it, its scale, that it was a rehearsal.
. "$(dirname "$0")/cli.bash"

plan raw.yaml "interval: 1h" "count: 6" "lamps: {mode: capture-only}" \
    "shot: {exposure: 20ms, lamps: {left: 100%, right: 100%}}" "keep: raw"
expect 0 "$TTFBOX" capture raw.yaml "${TINY[@]}" -o raw
expect 0 "$TTFBOX" note raw "a fly" --author Ada --tag exclude --slots 2-3
expect 0 "$TTFBOX" note raw "watered" --slots 4
expect 0 "$TTFBOX" sample raw A1 --region 2,3,20x10 --title "Lolium perenne"
expect 0 "$TTFBOX" develop raw -o developed
cmp raw/notes.jsonl developed/notes.jsonl || fail "the notes are others"
expect 0 "$TTFBOX" info developed --json
is samples.0.id A1
is samples.0.title "Lolium perenne"
expect 0 "$TTFBOX" verify developed
expect 0 "$TTFBOX" export developed -o out.npy --json
"$PYTHON" - out.npy.json <<'END' || fail "what is excluded was exported"
import json, sys
assert json.load(open(sys.argv[1]))["excluded_slots"] == [2, 3]
END

# Whatever people wrote is taken along as it is, also what nobody understands; a link is not followed, and is no reason to stop.
printf '%s\n' '{"slots":[[1,1]],"tags":["bad light"]}' '{"utc_ns":5,"author":"Ada"}' 'no JSON' >>raw/notes.jsonl
echo 'no JSON either' >raw/samples.json
expect 0 "$TTFBOX" develop raw -o odd
cmp raw/notes.jsonl odd/notes.jsonl || fail "the notes are not as they were"
cmp raw/samples.json odd/samples.json || fail "the samples are not as they were"
rm raw/samples.json
ln -s /etc/hostname raw/samples.json
expect 0 "$TTFBOX" develop raw -o linked
said err "samples.json is not taken over"
[ ! -e linked/samples.json ] || fail "a link was followed"
rm raw/samples.json

# The calibration's scale is the new dataset's, but where the plan has one.
SQUARE=("${TINY[@]}" --set sim.sensor.width=512px --set sim.sensor.height=384px --set sim.optics.margin=0%
    --set sim.optics.perspective=0 --set sim.optics.blur=0px)
plan one.yaml "interval: 1h" "count: 1" "lamps: {mode: continuous}" \
    "shot: {exposure: 20ms, lamps: {left: 100%, right: 100%}}" "keep: raw"
sed 's/^count: 1/&\nmm_per_px: 0.5/' one.yaml >scaled.yaml
expect 0 "$TTFBOX" calibrate dark "${SQUARE[@]}" --plan one.yaml --frames 8 -o cal
expect 0 "$TTFBOX" calibrate geometry "${SQUARE[@]}" --plan one.yaml --scene dots --pitch 5 --frames 8 -o cal
for plan in one scaled; do
    expect 0 "$TTFBOX" capture $plan.yaml "${SQUARE[@]}" -o $plan
    expect 0 "$TTFBOX" develop $plan -c cal -o $plan-cal
done
"$PYTHON" - one-cal scaled-cal <<'END' || fail "the scale is not told"
import json, sys
measured, planned = (json.load(open(f"{name}/dataset.json"))["streams"][0]["mm_per_px"] for name in sys.argv[1:])
assert abs(measured / (16 * 5 / 512) - 1) < 5e-4, measured
assert planned == 0.5, planned
END

# What was tried before a capture stays a trial, whatever is made of it.
expect 0 "$TTFBOX" capture raw.yaml "${TINY[@]}" --rehearse 2 -o tried
grep -qi nan "$WORK/out" && fail "a figure of pictures that were not developed"
expect 0 "$TTFBOX" develop tried -o tried-developed
said out "of a rehearsal"
expect 0 "$TTFBOX" synth quilt tried-developed --size 48x48 --block 16x16 -o tried-quilt
for made in tried-developed tried-quilt; do
    grep -q '"rehearsal": *true' $made/dataset.json || fail "$made does not say that it is of a rehearsal"
    expect 0 "$TTFBOX" verify $made
    expect 0 "$TTFBOX" info $made --json
    is sealed false
done
