#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measurements: figures and ratios of one run, never pass or fail. Called by ./dev bench from the root.
set -euo pipefail
box=build/bin/ttfbox

week() { python3 tests/bench/week.py "$box" boards/sim/plans/grass-week.yaml --board sim; }
schedule() { python3 tests/bench/schedule.py "$box" --board boards/sim/real-clock.yaml "$@"; }
synth() { build/tests/bench_quilt "$@"; }

case ${1:-all} in
week) week ;;
schedule) shift; schedule "$@" ;;
synth) shift; synth "$@" ;;
all) week; schedule; synth ;;
*)
    echo "bench: there is no '$1': week, schedule, synth" >&2
    exit 2
    ;;
esac
