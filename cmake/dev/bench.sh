#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measurements: figures and ratios of one run, never pass or fail. Called by ./dev bench from the root.
set -euo pipefail
box=build/bin/ttfbox

week() { python3 tests/bench/week.py "$box" boards/sim/plans/grass-week.yaml --board sim; }
schedule() { python3 tests/bench/schedule.py "$box" --board boards/sim/real-clock.yaml "$@"; }
# Of the folders of pictures given; else the sections named (agreement, coherence, ...; none: all) of synth.py.
synth() {
    if [ -d "${1:-}" ]; then
        build/tests/bench_quilt "$@"
        return
    fi
    python3 -u tests/bench/synth.py "$box" build/tests "$@"
}
# Quilting of single pictures beside another program's synthesis; not part of all, which needs only this project.
gmic() { python3 tests/bench/against_gmic.py "$box" build/tests/bench_patches "$@"; }

# Opening an unsealed dataset that was cut in a commit, to go on.
recovery() { for slots in 250 2500 25000; do build/tests/store_recovery $slots | grep slots,; done; }

# `ttfbox pull` beside curl fetching the same files; --help of the script names its options.
pull() { python3 -u tests/bench/pull.py "$box" build/tests/bench_no_hash.so "$@"; }

case ${1:-all} in
week) week ;;
schedule) shift; schedule "$@" ;;
pull) shift; pull "$@" ;;
synth) shift; synth "$@" ;;
recovery) recovery ;;
gmic) shift; gmic "$@" ;;
all) week; schedule; synth ;;
*)
    echo "bench: there is no '$1': week, schedule, recovery, synth, gmic, pull" >&2
    exit 2
    ;;
esac
