#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What results say of themselves: SIMULATED wherever a format has a place for it, and whose colours.
. "$(dirname "$0")/cli.bash"

# Words in a file, as it is.
holds() { # FILE WORDS
    grep -qaF -- "$2" "$1" || fail "$1 does not say '$2'"
}
lacks() {
    grep -qaF -- "$2" "$1" && fail "$1 says '$2'"
    return 0
}

plan two.yaml "interval: 1h" "count: 3" "lamps: {mode: capture-only}" \
    "shot: {exposure: 20ms, lamps: {left: 100%}}" "keep: both"
expect 0 "$TTFBOX" capture two.yaml "${TINY[@]}" -o sim

# The same pictures, imported: no invention as far as anybody can know.
expect 0 "$TTFBOX" export sim --to png -o pngs
expect 0 "$TTFBOX" import pngs/*.png --interval 1h -o real

# ---- exports ----
for ds in sim real; do
    mark=holds && [ $ds = real ] && mark=lacks
    simulated=true && [ $ds = real ] && simulated=false
    expect 0 "$TTFBOX" export $ds --to png -o $ds-png
    expect 0 "$TTFBOX" export $ds --to tiff -o $ds-tiff
    for kind in sheet npy y4m; do
        expect 0 "$TTFBOX" export $ds --to $kind -o $ds.$kind
    done
    $mark $ds-png/frame.1001.png SIMULATED
    $mark $ds-tiff/frame.1001.tif SIMULATED
    $mark $ds.sheet SIMULATED
    $mark $ds.y4m " XSIMULATED"
    for sidecar in $ds-png/frame.json $ds-tiff/frame.json $ds.npy.json $ds.y4m.json; do
        holds "$sidecar" "\"simulated\": $simulated"
    done
    if ! command -v ffmpeg >/dev/null; then
        echo "ffmpeg is not installed: mp4 and gif were not tried"
        continue
    fi
    for kind in mp4 gif; do
        expect 0 "$TTFBOX" export $ds --to $kind -o $ds.$kind
        $mark $ds.$kind SIMULATED
        holds $ds.$kind.json "\"simulated\": $simulated"
        [ "$(ffprobe -v error -count_frames -show_entries stream=nb_read_frames -of csv=p=0 $ds.$kind)" = 3 ] ||
            fail "$ds.$kind has not 3 frames"
    done
    [ $ds = sim ] || continue
    ffprobe -v error -show_entries format_tags=comment -of csv=p=0 sim.mp4 | grep -qx SIMULATED ||
        fail "ffprobe sees no comment"
    [ -z "$(ffprobe -v error sim.y4m 2>&1)" ] || fail "ffprobe stumbles over the y4m's mark"
done

# ---- a synthesis means what its input means ----
expect 0 "$TTFBOX" info sim --json
is streams.0.colour_space camera
expect 0 "$TTFBOX" synth quilt sim --block 16x16 --size 64x64 -o simq
expect 0 "$TTFBOX" info simq --json
is streams.0.colour_space camera
is streams.0.quantity radiance
is simulated true
holds simq/report.json '"simulated": true'
expect 0 "$TTFBOX" synth quilt real --block 16x16 --size 64x64 -o realq
expect 0 "$TTFBOX" info realq --json
is streams.0.colour_space linear-srgb
holds realq/report.json '"simulated": false'

# A profile (all have these four bytes) only where its primaries are meant.
holds real/frames/main/000000.tif acsp
holds realq/frames/main/000000.tif acsp
holds real-tiff/frame.1001.tif acsp
expect 0 "$TTFBOX" develop sim -o sim2
for file in sim/frames/main/000000.tif sim2/frames/main/000000.tif simq/frames/main/000000.tif \
    sim-tiff/frame.1001.tif; do
    lacks $file acsp
done

# ---- of the machine that built the program, nothing ----
for ds in sim sim2 simq real realq; do
    grep -rqaF -- "$SOURCE" $ds && fail "$ds names the folder that the program was built in"
done
echo "marks: simulated, colours, profiles"
