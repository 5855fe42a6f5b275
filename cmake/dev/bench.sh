#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measurements: figures and ratios of one run, never pass or fail. Called by ./dev bench from the root.
set -euo pipefail
box=build/bin/ttfbox

week() { python3 tests/bench/week.py "$box" boards/sim/plans/grass-week.yaml --board sim; }
schedule() { python3 tests/bench/schedule.py "$box" --board boards/sim/real-clock.yaml "$@"; }
# Of the folders of pictures given; else of the real sequences, where they are, and of a simulated week.
synth() {
    if [ $# -gt 0 ]; then
        build/tests/bench_quilt "$@"
        return
    fi
    local data=${TTFBOX_TEST_DATA:-../shared/data} name
    for name in copper clay; do
        if [ -d "$data/timelapse/$name" ]; then
            echo "== $name"
            build/tests/bench_quilt "$data/timelapse/$name"
        else
            echo "== $name: skipped, $data is not there"
        fi
    done
    echo "== a simulated week of grass"
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
    "$box" capture boards/sim/plans/demo.yaml --board sim-small -o "$scratch/grass" -q >"$scratch/log"
    "$box" export "$scratch/grass" --to png -o "$scratch/png" -q >>"$scratch/log"
    build/tests/bench_quilt "$scratch/png" --block 64x128
}
# Quilting of single pictures beside another program's synthesis; not part of all, which needs only this project.
gmic() { python3 tests/bench/against_gmic.py "$box" build/tests/bench_patches "$@"; }

case ${1:-all} in
week) week ;;
schedule) shift; schedule "$@" ;;
synth) shift; synth "$@" ;;
gmic) shift; gmic "$@" ;;
all) week; schedule; synth ;;
*)
    echo "bench: there is no '$1': week, schedule, synth, gmic" >&2
    exit 2
    ;;
esac
