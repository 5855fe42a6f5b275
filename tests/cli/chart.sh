#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A camera whose filters are not sharp photographs a colour chart, and from then on sees the colours that a sharp one sees;
# lamps that ripple are found out, and what helps.
. "$(dirname "$0")/cli.bash"

BOX=(--board sim-small --set sim.sensor.width=240px --set sim.sensor.height=160px --set sim.optics.blur=0px
    --set sim.optics.perspective=0.06)
SOFT=(--set sim.sensor.colour_mix=9%)
plan p.yaml "interval: 1h" "count: 1" "lamps: {mode: continuous}" \
    "shots: [{lamps: {left: 100%, right: 100%}, exposure: 20ms, average: 4}]" "keep: developed"

for camera in sharp soft; do
    mix=()
    [ "$camera" = sharp ] || mix=("${SOFT[@]}")
    expect 0 "$TTFBOX" calibrate dark "${BOX[@]}" "${mix[@]}" --plan p.yaml --frames 16 -o "$camera"
    expect 2 "$TTFBOX" calibrate chart "${BOX[@]}" "${mix[@]}" --plan p.yaml --scene chart --frames 4 -o "$camera"
    said err "no flat yet"
    expect 0 "$TTFBOX" calibrate flat "${BOX[@]}" "${mix[@]}" --plan p.yaml --scene white --frames 16 -o "$camera"
    expect 0 "$TTFBOX" capture p.yaml "${BOX[@]}" "${mix[@]}" --scene chart -c "$camera" -o "$camera-plain"
    expect 0 "$TTFBOX" export "$camera-plain" -o "$camera.npy"
done

# A flat's gains are of the dark that was there: none comes behind it.
expect 0 "$TTFBOX" calibrate flat "${BOX[@]}" --plan p.yaml --scene white --frames 4 -o bright
expect 2 "$TTFBOX" calibrate dark "${BOX[@]}" --plan p.yaml --frames 4 -o bright
said err "has a flat"
said err "the dark first"
expect 0 "$TTFBOX" calibrate report bright --json
is has_dark false

# Not the chart, not where it is.
expect 2 "$TTFBOX" calibrate chart "${BOX[@]}" "${SOFT[@]}" --plan p.yaml --scene chart --corners 1,2,3 -o soft
said err "eight numbers"
expect 2 "$TTFBOX" calibrate chart "${BOX[@]}" "${SOFT[@]}" --plan p.yaml --scene chart --corners 10,10,90,10,90,70,10,70 -o soft
said err "let the chart fill more of the frame"
expect 2 "$TTFBOX" calibrate chart "${BOX[@]}" "${SOFT[@]}" --plan p.yaml --scene copper --frames 4 -o soft
said err "no grey scale"
expect 2 "$TTFBOX" calibrate chart "${BOX[@]}" "${SOFT[@]}" --plan p.yaml --scene chart --values nowhere.txt -o soft
expect 0 "$TTFBOX" calibrate report soft --json
is has_chart false

expect 0 "$TTFBOX" calibrate chart "${BOX[@]}" "${SOFT[@]}" --plan p.yaml --scene chart --frames 16 -o soft
said out "CIEDE2000"
expect 0 "$TTFBOX" calibrate report soft --json
is has_chart true
"$PYTHON" - out <<'END' || fail "the chart's colours did not come back"
import json, sys
said = json.load(open(sys.argv[1], encoding="utf-8"))
assert said["chart_delta_e_before_mean"] > 3, said
assert said["chart_delta_e_mean"] < 0.2, said
END
expect 2 "$TTFBOX" calibrate chart "${BOX[@]}" "${SOFT[@]}" --plan p.yaml --scene chart -o soft
said err "holds a chart already"

expect 0 "$TTFBOX" capture p.yaml "${BOX[@]}" "${SOFT[@]}" --scene chart -c soft -o soft-chart
expect 0 "$TTFBOX" export soft-chart -o soft-chart.npy
before=$("$PYTHON" "$HERE/pictures.py" mae soft.npy sharp.npy)
after=$("$PYTHON" "$HERE/pictures.py" mae soft-chart.npy sharp.npy)
echo "off a sharp camera's colours: $before of full scale without a chart, $after with"
"$PYTHON" -c "import sys; sys.exit(not ($before > 0.015 and $after < 0.006))" || fail "the colours are not a sharp camera's"

# Lamps that ripple at 100 Hz: whole half-periods hide it, others do not, also where the camera's period is one of the mains'.
RIPPLE=(--set sim.lamps.left.ripple=30% --set sim.lamps.right.ripple=30% --scene white)
sed 's/20ms/7ms/' p.yaml >short.yaml
echo "mains: none" >>short.yaml
expect 0 "$TTFBOX" calibrate flicker "${BOX[@]}" "${RIPPLE[@]}" --plan short.yaml
said out "The light flickers. An exposure of whole half-periods"
expect 0 "$TTFBOX" calibrate flicker "${BOX[@]}" "${RIPPLE[@]}" --plan p.yaml -o sharp --json
is steady true
is has_flicker true
expect 2 "$TTFBOX" calibrate flicker "${BOX[@]}" "${RIPPLE[@]}" --plan p.yaml -o sharp
said err "holds a flicker already"
expect 0 "$TTFBOX" calibrate flicker "${BOX[@]}" "${RIPPLE[@]}" --set sim.mains=60Hz --plan p.yaml
said out "half-periods of 50 Hz: the mains has another frequency"
expect 0 "$TTFBOX" calibrate report sharp
said out "frames differ by 0.0"
expect 2 "$TTFBOX" calibrate flicker "${BOX[@]}" --plan p.yaml --frames 3
said err "8 frames or more"
expect 2 "$TTFBOX" calibrate flicker "${BOX[@]}" "${RIPPLE[@]}" --plan p.yaml -o nothing-there
said err "neither dark nor flat"
[ ! -e nothing-there ] || fail "a calibration of nothing was left"
