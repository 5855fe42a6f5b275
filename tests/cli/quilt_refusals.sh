#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What makes no sense is refused before anything is written; what is stopped leaves nothing.
. "$(dirname "$0")/cli.bash"

mkdir in
"$PYTHON" "$HERE/pictures.py" make in 6 60 48 || fail "making pictures"
expect 0 "$TTFBOX" import in/*.png --interval 1min -o d
expect 0 "$TTFBOX" import in/p[0-3].png --interval 1min -o d4
expect 0 "$TTFBOX" synth quilt d --size 50x40 --block 16x16 --sink raw -o plain.rgb --save-map map.json
expect 0 "$TTFBOX" synth quilt d --size 50x40 --block 16x16 --sink raw -o jit.rgb --jitter 1 --save-map jit.json
ls -A >before

# refuse WORDS OPTIONS...: exit 2, the words in the message.
refuse() {
    local words=$1
    shift
    expect 2 "$TTFBOX" synth quilt d --sink raw -o never "$@"
    said err "$words"
}
B=(--block 16x16)
P=in/p0.png

# ---- values ----
refuse "--block" --block 12
refuse "--block" --block automatic
refuse "--block: a block of 640 x 480 does not fit" --block 640x480
refuse "--overlap" "${B[@]}" --overlap 12x2
refuse "--feather" "${B[@]}" --feather 9
refuse "--tileable" "${B[@]}" --tileable --size 10x10
refuse "--rank" "${B[@]}" --rank 0
refuse "--rank" "${B[@]}" --rank 65
refuse "--rank" "${B[@]}" --rank most
refuse "--rank-error" "${B[@]}" --rank-error 0
refuse "--rank-error" "${B[@]}" --rank-error 101
refuse "--svd" "${B[@]}" --svd both
refuse "--avoid" "${B[@]}" --avoid -1
refuse "--jitter" "${B[@]}" --jitter -1
refuse "--jitter" "${B[@]}" --jitter 1.5
refuse "--light" "${B[@]}" --light 1,2
refuse "--light" "${B[@]}" --light 1,2,3,4
refuse "--light" "${B[@]}" --light 1,2,x
refuse "--light" "${B[@]}" --light 0.5,0.5,0
refuse "--rate-gain" "${B[@]}" --rate-map $P --rate-gain nan
refuse "--rate-map" "${B[@]}" --rate-map $P --rate-gain 0.000001
refuse "--memory" "${B[@]}" --memory 64
refuse "--memory" "${B[@]}" --memory 64parsec
refuse "--time" "${B[@]}" --preview --time 10
refuse "--deflicker-window" "${B[@]}" --deflicker --deflicker-window 8
refuse "--flatten-sigma" "${B[@]}" --flatten --flatten-sigma 0
refuse "--agreement" "${B[@]}" --agreement 0
refuse "--factors: is empty" "${B[@]}" --factors ""
refuse "--source" "${B[@]}" --source nowhere
refuse "--source: input 2 has 4 frames" "${B[@]}" --source d4

# ---- files that are not what they should be ----
printf 'no picture' >text && printf '0,0\n1,x\n2,0\n' >bad.csv && printf '0,0\n1,1\n' >short.csv
printf '0,0\n0,1\n2,0\n' >back.csv && printf '{"format":"ttfbox quilt map"}' >bad.json && : >empty
refuse "--rate-map" "${B[@]}" --rate-map nowhere.png
refuse "--rate-map" "${B[@]}" --rate-map text
refuse "--normals" "${B[@]}" --light 0.5,0.3,0.4 --normals text
refuse "--heights" "${B[@]}" --light 0.5,0.3,0.4 --heights nowhere.png
refuse "--curvature" "${B[@]}" --curvature nowhere.csv
refuse "bad.csv:2" "${B[@]}" --curvature bad.csv
refuse "back.csv:2" "${B[@]}" --curvature back.csv
refuse "--curvature" "${B[@]}" --curvature short.csv
refuse "--curvature" "${B[@]}" --curvature text
refuse "--map" --map nowhere.json
refuse "--map bad.json" --map bad.json
refuse "--map empty" --map empty
refuse "--factors" "${B[@]}" --factors text
refuse "--factors" "${B[@]}" --factors empty
refuse "--factors" "${B[@]}" --factors d
refuse "text: exists already" "${B[@]}" --save-map text
refuse "inside of the dataset" "${B[@]}" --save-map d/map.json
refuse "inside of the dataset" "${B[@]}" --factors d/factors
refuse "--save-map: never lies where never will be" "${B[@]}" --save-map never
refuse "--save-map: ./never/map.json: there is no such folder" "${B[@]}" --save-map ./never/map.json
refuse "--factors: ../${PWD##*/}/never lies" "${B[@]}" --factors "../${PWD##*/}/never"
refuse "--factors: f lies where f will be" "${B[@]}" --factors f --save-map f
mkdir empty-folder
expect 2 "$TTFBOX" synth quilt d "${B[@]}" -o empty-folder --save-map empty-folder/map.json
said err "--save-map"
rmdir empty-folder
rm text bad.csv short.csv back.csv bad.json empty

# ---- what does not go together ----
while read -r words; do
    read -ra options <<<"$words"
    refuse "${options[0]}" "${options[@]}"
done <<END
--rank 5 --rank-error 2
--rank full --factors f
--rank full --mirror
--rank full --flips
--rank full --rotations
--rank full --tileable
--rank full --avoid 3
--rank full --source d
--rank full --svd channels
--rank full --agreement 3
--rate-map $P --light 0.5,0.3,0.4
--rate-map $P --curvature sigmoid
--light 0.5,0.3,0.4 --curvature sigmoid
--normals $P --light 0.5,0.3,0.4 --heights $P
--normals $P
--heights $P
--height-scale 2
--height-scale 2 --curvature sigmoid
--rate-offset 1
--rate-gain 2
--jitter-rounded
--keep-gradient
--keep-gradient --flatten --tileable
--flatten-sigma 5
--deflicker-window 5
--time 5s
--figures --no-figures
--factors f --per-frame
--save-map never.json --per-frame
--agreement 3 --per-frame
--agreement 3 --source d
--agreement 3 --tileable
--per-frame --jitter 1
--per-frame --rate-map $P
--per-frame --source d
--map map.json --size 50x40
--map map.json --block 16x16
--map map.json --block auto
--map map.json --overlap 3x3
--map map.json --tolerance 0.2
--map map.json --seed 3
--map map.json --metric linear
--map map.json --per-frame
--map map.json --feather 2
--map map.json --rank 5
--map map.json --rank-error 5
--map map.json --svd channels
--map map.json --factors f
--map map.json --jitter 1
--map map.json --mirror
--map map.json --flips
--map map.json --rotations
--map map.json --tileable
--map map.json --avoid 3
--map map.json --save-map never.json
--map map.json --agreement 3
--map map.json --preview
END
for how in "--jitter 1" "--rate-map $P" "--light 0.5,0.3,0.4" "--curvature sigmoid" "--flatten --keep-gradient"; do
    # shellcheck disable=SC2086
    expect 2 "$TTFBOX" synth quilt d "${B[@]}" -o never --check $how
    said err "--check: does not go together with"
done
expect 2 "$TTFBOX" synth quilt d -o never --check --map jit.json
said err "--check"
expect 0 "$TTFBOX" synth quilt d "${B[@]}" -o feathered --check --feather 2 --flatten --json
[ "$(json unmatched_pixels)" -gt 0 ] || fail "a blend that is nobody's life is not counted"
expect 0 "$TTFBOX" synth quilt d -o mapped --check --map map.json --json
is unmatched_pixels 0
rm -r feathered mapped

# A map is of inputs of one size, and of as many frames as have times.
expect 0 "$TTFBOX" synth quilt d4 --block 16x16 --sink raw -o four.rgb --jitter 1 --save-map four.json
refuse "--map: its times are of 4 frames" --map four.json
expect 2 "$TTFBOX" synth quilt in/p0.png --sink raw -o never --map map.json --source in/p1.png
said err "--map: it is of 1 input"
rm four.rgb four.json

# Light as the camera saw it and reflectances of the same codes are no one material.
plan p.yaml "interval: 30min" "count: 3" "lamps: {mode: continuous, settle: 5s}" \
    "shot: {lamps: {left: 100%, right: 100%}, exposure: 20ms}"
expect 0 "$TTFBOX" calibrate dark "${TINY[@]}" --plan p.yaml --frames 2 -o cal
expect 0 "$TTFBOX" calibrate flat "${TINY[@]}" --plan p.yaml --scene white --frames 2 -o cal
expect 0 "$TTFBOX" capture "${TINY[@]}" p.yaml -o seen
expect 0 "$TTFBOX" capture "${TINY[@]}" p.yaml -c cal -o reflected
expect 2 "$TTFBOX" synth quilt seen --source reflected "${B[@]}" --sink raw -o never
said err "--source: reflected is of reflectance (unit 1, colours linear-srgb), the first input of radiance (unit 1, colours camera)"
expect 0 "$TTFBOX" synth quilt seen --source seen "${B[@]}" --sink null
rm -r cal seen reflected p.yaml

# A command takes only what it can do something with.
expect 2 "$TTFBOX" synth composite $P d --rate-map $P -o never
expect 2 "$TTFBOX" synth composite $P d --map map.json -o never
expect 2 "$TTFBOX" synth composite $P -o never
expect 2 "$TTFBOX" synth rank d --block 16x16 -o never.csv

# ---- stopped in the midst: a signal takes everything away ----
expect 0 "$TTFBOX" import in/*.png --interval 1min -o e
for sink in raw dataset; do
    "$TTFBOX" synth quilt e --size 4000x3000 "${B[@]}" --sink $sink -o never --save-map never.json --factors never.f \
        >"$WORK/out" 2>"$WORK/err" &
    for _ in $(seq 200); do # until there is something to take away
        begun=$(compgen -G never || compgen -G '.never.part-*') && break
        sleep 0.02
    done
    [ "$begun" ] || fail "nothing was begun"
    kill -INT $!
    wait $!
    [ $? = 1 ] || fail "stopped, it ended otherwise"
    [ -e never ] && fail "a stopped synthesis left its output ($sink)"
    compgen -G '.never*' && fail "a stopped synthesis left what was to be its output"
    [ -e never.json ] && fail "a stopped synthesis left its map"
    if [ -e never.f ]; then # all of it, or nothing
        expect 0 "$TTFBOX" synth quilt e "${B[@]}" --sink null --factors never.f --json
        is report.compression.frames_known_before 6
        rm never.f
    fi
done
rm -r e

rm -f out err
diff <(grep -vE '^(before|out|err)$' before) <(ls -A --ignore=before) || fail "something was left"
echo "quilt refusals: all refused, nothing left"
