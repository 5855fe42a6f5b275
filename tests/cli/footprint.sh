#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Memory: a run with a camera of 12 megapixels keeps within what a board of 512 MiB can give, the simulator's world included; so does
# one of many slots, and the program itself is small.
. "$(dirname "$0")/cli.bash"

# peak COMMAND...: runs it; the most memory it held at a time, KiB, in $WORK/peak. What Python itself holds before is far less.
peak() {
    "$PYTHON" - "$@" <<'EOF' >"$WORK/peak" || fail "exit not 0: $*"
import resource, subprocess, sys
done = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=open("err", "w"))
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
sys.exit(done.returncode)
EOF
}
# within KIB WHAT
within() {
    [ "$(cat "$WORK/peak")" -le "$1" ] || fail "$2: $(cat "$WORK/peak") KiB, more than $1"
}

# Under a sanitizer memory is another thing.
ldd "$TTFBOX" | grep -qE 'libasan|libtsan|libubsan' && exit 77

plan p.yaml 'interval: 10s' 'count: 2' 'lamps: {mode: capture-only, settle: 150ms}' 'shots: [{lamps: {left: 100%}}]' 'keep: both' 'reserve: 1MB'
set -- capture p.yaml --quiet --threads=2 --no-speed-check --set sim.timing.buffers=2
FRAME=$((4056 * 3040 * 2 / 1024))
peak "$TTFBOX" "$@" -o large --set sim.sensor.width=4056px --set sim.sensor.height=3040px --set sim.optics.detail=1024px
within $((64 * 1024 + (2 + 3) * FRAME)) "12 megapixels, 2 buffers"
expect 0 "$TTFBOX" info large --json
is slots 2

peak "$TTFBOX" "$@" -o small --set sim.sensor.width=64px --set sim.sensor.height=48px
within $((24 * 1024)) "without frames to speak of"
