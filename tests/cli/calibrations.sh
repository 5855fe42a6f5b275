#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A run that is gone on with another calibration: each picture names its own, is developed anew with it to the bit, and both are guarded.
. "$(dirname "$0")/cli.bash"

BOX=(--board sim-small --set sim.sensor.width=96px --set sim.sensor.height=64px)
plan p.yaml "interval: 30min" "count: 6" "lamps: {mode: continuous, settle: 5s}" \
    "shot: {lamps: {left: 100%, right: 100%}, exposure: 20ms}" "keep: both" "reserve: 0B"
for n in 1 2; do
    expect 0 "$TTFBOX" calibrate dark "${BOX[@]}" --plan p.yaml --frames 4 --seed "$n" -o "cal-$n"
    expect 0 "$TTFBOX" calibrate flat "${BOX[@]}" --plan p.yaml --scene white --frames 4 --seed "$n" -o "cal-$n"
done
id() { "$PYTHON" -c 'import json, sys; print(json.load(open(sys.argv[1]))["id"])' "$1/calibration.json"; }
[ "$(id cal-1)" != "$(id cal-2)" ] || fail "both calibrations are the same"
of_slots() { # DATASET: the calibration of each picture, a letter for each
    "$PYTHON" - "$1" "$(id cal-1)" "$(id cal-2)" <<'END'
import json, sys
names = {sys.argv[2]: "1", sys.argv[3]: "2"}
for line in open(sys.argv[1] + "/records.jsonl"):
    record = json.loads(line)
    for image in record.get("images", []):
        print(names.get(image.get("calibration"), "-"), end="")
END
}

printf '3 stop\n' >stop
expect 1 "$TTFBOX" capture "${BOX[@]}" p.yaml -c cal-1 -o grass --script stop
expect 0 "$TTFBOX" capture "${BOX[@]}" p.yaml -c cal-2 -o grass
[ "$(of_slots grass)" = 111222 ] || fail "the pictures are of $(of_slots grass)"
expect 0 "$TTFBOX" verify grass
expect 0 "$TTFBOX" info grass
said out "calibrations      2: each picture names its own"

# ---- developed anew, each with its own: the same pictures ----
expect 0 "$TTFBOX" develop grass -o anew
said out "calibrations      2: each picture with its own"
[ "$(of_slots anew)" = 111222 ] || fail "the pictures developed anew are of $(of_slots anew)"
for file in grass/frames/main/*; do
    cmp "$file" "anew/${file#grass/}" || fail "$file is another picture"
done
expect 0 "$TTFBOX" verify anew

# ---- or all with one ----
expect 0 "$TTFBOX" develop grass -c cal-2 -o one
[ "$(of_slots one)" = 222222 ] || fail "the pictures developed with one are of $(of_slots one)"
said out "calibration       $(id cal-2)"

# ---- what fails half-way leaves nothing; what was killed is never taken for whole ----
cp -r grass torn
printf x | dd of=torn/raw/main/000004.dng bs=1 seek=3000 conv=notrunc 2>/dev/null
truncate -s 3001 torn/raw/main/000004.dng
expect 3 "$TTFBOX" develop torn -o never
said err "000004.dng"
[ -e never ] && fail "a development that failed in its fifth slot left its output"
# No file may be as long as a picture is: to a program that is a limit of its user's, not a full disk, hence 2.
(ulimit -f 32; trap '' XFSZ; expect 2 "$TTFBOX" develop grass -o never) || exit 1
said err "too large"
[ -e never ] && fail "a development that found no room left its output"
plan long.yaml "interval: 30min" "count: 200" "shot: {exposure: 20ms}" "keep: raw" "reserve: 0B"
expect 0 "$TTFBOX" capture --board sim-small long.yaml -o long
"$TTFBOX" develop long -o never >out 2>err &
for _ in $(seq 500); do # until it is in its fifth slot of 200: half a second before its end, of a processor as there are today
    [ -e never/frames/main/000003.tif ] && break
    sleep 0.01
done
kill -KILL $!
wait $! && fail "it was not killed"
expect 0 "$TTFBOX" verify never --json
is sealed false
expect 2 "$TTFBOX" develop long -o never
rm -r torn never long

# ---- what is found in one says which slots it concerns ----
printf x | dd of="grass/calibration/$(id cal-1)/flat.tif" bs=1 seek=700 conv=notrunc 2>/dev/null
expect 3 "$TTFBOX" verify grass
said out "calibration/$(id cal-1)/flat.tif"
! grep -q "$(id cal-2)" out || fail "the other calibration is blamed too: $(cat out)"

# ---- values do not change their meaning within a dataset ----
expect 1 "$TTFBOX" capture "${BOX[@]}" p.yaml -c cal-1 -o kept --script stop
expect 2 "$TTFBOX" capture "${BOX[@]}" p.yaml -o kept
said err "with quantity radiance"
