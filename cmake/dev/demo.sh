#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The main job on the simulated box, from calibration to a synthesized preview. Called by ./dev demo from the root.
# usage: demo.sh [FOLDER]   (default: demo-out; an earlier demo's results there are replaced)
set -euo pipefail
box=$PWD/build/bin/ttfbox
out=${1:-demo-out}
if [ -e "$out" ] && [ ! -e "$out/.ttfbox-demo" ]; then
    echo "demo: $out exists and is not an earlier demo: name another folder" >&2
    exit 2
fi
rm -rf "$out"
mkdir -p "$out"
touch "$out/.ttfbox-demo"
begun=$SECONDS
plan=boards/sim/plans/demo.yaml
board=sim-small

say() { printf '\n== %s\n' "$*"; }
run() {
    printf '$ ttfbox %s\n' "$*"
    "$box" "$@"
}

say "The plan, checked"
run plan check "$plan" --board "$board"
say "Calibration: lamps off for the dark, an even white target for the flat"
run calibrate dark --board "$board" --plan "$plan" -o "$out/calibration"
run calibrate flat --board "$board" --plan "$plan" --scene white -o "$out/calibration"
say "A week of growing grass, in virtual time"
run capture "$plan" --board "$board" -c "$out/calibration" -o "$out/grass"
say "Verified by us, and by a tool that knows nothing of us"
run verify "$out/grass"
(cd "$out/grass" && sha256sum --strict --quiet -c SHA256SUMS && echo "sha256sum --strict -c: all files are as recorded")
say "What it is"
run info "$out/grass"
say "To look at"
run export "$out/grass" --to sheet --frames 8 --columns 4 -o "$out/grass-sheet.png"
run export "$out/grass" --to mp4 -o "$out/grass.mp4"
say "A larger lawn, grown from the week"
run synth quilt "$out/grass" --size 768x576 --block 64x128 --seed 4 --check -o "$out/lawn"
run export "$out/lawn" --to mp4 -o "$out/lawn.mp4"
run export "$out/lawn" --to sheet --frames 8 --columns 4 -o "$out/lawn-sheet.png"

cat <<END

== Done in $((SECONDS - begun)) s. All of it is SIMULATED.
  dataset        $out/grass            (ttfbox info $out/grass)
  contact sheet  $out/grass-sheet.png
  video          $out/grass.mp4
  preview        $out/lawn.mp4, $out/lawn-sheet.png; its dataset $out/lawn, figures in $out/lawn/report.json
Pictures open in any viewer, videos in any player or browser: xdg-open $out/lawn.mp4
END
