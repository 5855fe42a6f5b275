#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A folder of pictures as what the simulated camera looks at: the calibrated dataset
# matches the scene's nearest frame within 2 % of full scale.
. "$(dirname "$0")/cli.bash"

# match FOLDER N W H LIMIT: captures N slots of N pictures and compares in linear light.
match() {
    local folder=$1 n=$2 w=$3 h=$4
    local box=(--board sim-small --set "sim.sensor.width=${w}px" --set "sim.sensor.height=${h}px"
        --set sim.optics.perspective=0 --set sim.optics.blur=0px --set sim.optics.margin=0)
    plan p.yaml "interval: 1h" "count: $n" "lamps: {mode: continuous}" \
        "shots: [{lamps: {left: 100%, right: 100%}, exposure: 20ms, average: 4}]" "keep: developed"
    rm -rf cal cap ref cap.npy* ref.npy*
    expect 0 "$TTFBOX" calibrate dark "${box[@]}" --plan p.yaml -o cal
    expect 0 "$TTFBOX" calibrate flat "${box[@]}" --plan p.yaml --scene white -o cal
    # Slot k looks at picture k: it comes minutes after k hours (the lamps warm up first), and
    # k hours of the span are picture k's time.
    expect 0 "$TTFBOX" capture p.yaml "${box[@]}" --scene "$folder" \
        --set "sim.scene={span: $((n - 1))h}" -c cal -o cap --json
    is captured "$n"
    expect 0 "$TTFBOX" import "$folder"/*.png --interval 1h -o ref
    expect 0 "$TTFBOX" export cap -o cap.npy
    expect 0 "$TTFBOX" export ref -o ref.npy
    mae=$("$PYTHON" "$HERE/pictures.py" mae cap.npy ref.npy) || fail "arrays cannot be compared"
    echo "scene $folder: greatest mean absolute error of a frame is $mae of full scale"
    "$PYTHON" -c "import sys; sys.exit(not $mae < 0.02)" || fail "more than 2 %: $mae"
}

mkdir in
"$PYTHON" "$HERE/pictures.py" make in 8 96 64 || fail "making pictures"
match in 8 96 64

# The same through a dataset: what it looks at is the import made above.
expect 0 "$TTFBOX" capture p.yaml --board sim-small --set sim.sensor.width=96px \
    --set sim.sensor.height=64px --scene ref -o from-dataset --json
is captured 8
# A sample's name stays one, also beside a folder of that name: run again, it goes on with the same sample.
plan cracks.yaml "interval: 1h" "count: 4" "lamps: {mode: continuous}" \
    "shots: [{lamps: {left: 100%, right: 100%}, exposure: 20ms}]" "keep: both"
for out in paint again; do
    expect 0 "$TTFBOX" capture cracks.yaml "${TINY[@]}" --scene paint --set sim.scene.span=4h -o $out
done
cmp paint/raw/main/000003.dng again/raw/main/000003.dng || fail "--scene paint looked at the folder paint"
mkdir empty
expect 2 "$TTFBOX" capture p.yaml --board sim-small --scene empty -o none
said err "no picture"

if [ -d "$DATA/timelapse/copper" ]; then
    mkdir metal
    for i in 000 020 040 060 080 099; do
        cp "$DATA/timelapse/copper/$i.png" metal/
    done
    match metal 6 256 256
else
    echo "$DATA/timelapse/copper is not there: the real sequence was not looked at"
fi
echo "scene: what is seen is what is kept"
