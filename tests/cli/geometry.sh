#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A printed grid of dots in the sample's place says how large a pixel is, and the datasets made afterwards say so too.
. "$(dirname "$0")/cli.bash"

# Seen squarely, 16 dots 5 mm apart fill 512 pixels but for the margin.
BOX=(--board sim-small --set sim.sensor.width=512px --set sim.sensor.height=384px --set sim.optics.margin=0%
    --set sim.optics.perspective=0 --set sim.optics.blur=0px)
plan p.yaml "interval: 1h" "count: 1" "lamps: {mode: continuous}" \
    "shots: [{lamps: {left: 100%, right: 100%}, exposure: 20ms}]" "keep: developed"

# Without a folder it is said, and nothing else happens.
expect 0 "$TTFBOX" calibrate geometry "${BOX[@]}" --plan p.yaml --scene dots --pitch 5 --frames 4
said out "mm per pixel"
expect 2 "$TTFBOX" calibrate geometry "${BOX[@]}" --plan p.yaml --scene dots
said err "as --pitch 5"
expect 2 "$TTFBOX" calibrate geometry "${BOX[@]}" --plan p.yaml --scene dots --pitch 0
expect 2 "$TTFBOX" calibrate geometry "${BOX[@]}" --plan p.yaml --scene grass --pitch 5 --frames 4
said err "5 columns and 5 rows are needed"
# ... before any frame is taken: what it would have seen does not matter.
expect 2 "$TTFBOX" calibrate geometry "${BOX[@]}" --plan p.yaml --scene grass --pitch 5 --frames 4 -o nothing-there
said err "neither dark nor flat"
[ ! -e nothing-there ] || fail "a calibration of nothing was left"

expect 0 "$TTFBOX" calibrate dark "${BOX[@]}" --plan p.yaml --frames 8 -o cal
expect 0 "$TTFBOX" calibrate flat "${BOX[@]}" --plan p.yaml --scene white --frames 8 -o cal
expect 0 "$TTFBOX" calibrate report cal --json
is has_geometry false
before=$("$PYTHON" -c 'import json, sys; print(json.load(open(sys.argv[1]))["id"])' out)
expect 0 "$TTFBOX" calibrate geometry "${BOX[@]}" --plan p.yaml --scene dots --pitch 5 --frames 8 -o cal
expect 0 "$TTFBOX" calibrate report cal --json
is has_geometry true
"$PYTHON" - out "$before" <<'END' || fail "the scale is wrong"
import json, sys
said = json.load(open(sys.argv[1], encoding="utf-8"))
assert abs(said["mm_per_px"] / (16 * 5 / 512) - 1) < 5e-4, said
assert abs(said["rotation_deg"]) < 0.05 and abs(said["distortion"]) < 1e-3, said
assert said["id"] == sys.argv[2], "a remark changed what frames are developed with"
END
expect 2 "$TTFBOX" calibrate geometry "${BOX[@]}" --plan p.yaml --scene dots --pitch 5 -o cal
said err "holds a geometry already"

# Datasets say it; the plan's own word goes before.
expect 0 "$TTFBOX" capture p.yaml "${BOX[@]}" --scene copper -c cal -o with
expect 0 "$TTFBOX" capture p.yaml "${BOX[@]}" --scene copper -o without
echo "mm_per_px: 0.25" >>p.yaml
expect 0 "$TTFBOX" capture p.yaml "${BOX[@]}" --scene copper -c cal -o own
"$PYTHON" - <<'END' || fail "the datasets' scales are wrong"
import json
def scale(name):
    return json.load(open(name + "/dataset.json", encoding="utf-8"))["streams"][0].get("mm_per_px")
assert abs(scale("with") / (16 * 5 / 512) - 1) < 5e-4, scale("with")
assert scale("without") is None and scale("own") == 0.25
END
