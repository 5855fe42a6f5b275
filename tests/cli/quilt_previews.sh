#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A first look keeps to its memory and says what it thinks of its time; it shows less of the same thing.
. "$(dirname "$0")/cli.bash"

frames() {
    "$PYTHON" "$HERE/frames.py" "$@" || fail "frames.py $*"
}

# holds EXPRESSION: a comparison that awk finds true.
holds() {
    awk "BEGIN { exit !($1) }" || fail "it is not so that $1"
}

# preview OPTIONS...: of d, nothing kept, its JSON in out.
preview() {
    expect 0 "$TTFBOX" synth quilt d --block 16x16 --sink null --preview --json "$@"
}

mkdir in
"$PYTHON" "$HERE/pictures.py" make in 16 60 48 || fail "making pictures"
expect 0 "$TTFBOX" import in/*.png --interval 1min -o d

# ---- an output that ages slowly is long, and the estimate counts its frames ----
frames picture halves halves.png 96 64
preview --size 96x64 --time 1h
plain=$(json preview.estimated_ns)
preview --size 96x64 --time 1h --rate-map halves.png --rate-gain 0.01
holds "$(json report.output_frames) > 1000"
holds "$(json preview.estimated_ns) > $plain + 1000 * 96 * 64 * 10"
for how in "--rate-map halves.png" "--light 0.5,0.3,0.4" "--curvature sigmoid"; do
    # shellcheck disable=SC2086
    preview --size 640x480 --time 3s $how --rate-gain 0.01
    holds "$(json report.output_frames) > 600 && $(json preview.shrunk_by) > 1"
    holds "$(json preview.estimated_ns) <= 3e9"
done

# ---- memory: of several inputs, and with all that is looked at besides ----
mkdir large
"$PYTHON" "$HERE/pictures.py" make large 12 256 256 || fail "making pictures"
expect 0 "$TTFBOX" import large/*.png --interval 1min -o l
rm -r large
# within SIZE OPTIONS...: a preview of l in so many MiB held no more.
within() {
    local size=$1 peak
    shift
    expect 0 "$TTFBOX" synth quilt l --block 32x32 --sink null --preview --time 1h --memory "${size}MiB" --json "$@"
    [ "$(json preview.estimated_bytes)" -le $((size << 20)) ] || fail "$*: estimated to pass $size MiB"
    peak=$(json report.memory_bytes.peak_resident)
    [ "$peak" -le $((size << 20)) ] || fail "$*: $peak bytes within $size MiB"
}
within 32 --source l --source l --source l --source l
within 40 --source l --source l --source l
within 60
plain=$(json preview.estimated_bytes)
within 60 --agreement 2
holds "$(json preview.estimated_bytes) >= $plain + 3 * 12 * 256 * 256"
expect 2 "$TTFBOX" synth quilt l --block 32x32 --sink null --agreement 2 --memory 16MiB
said err "16 MiB are allowed"
said err "do without the comparison"
expect 0 "$TTFBOX" synth quilt l --block 32x32 --sink null --memory 16MiB

for left in never never.csv never.svg; do
    [ -e $left ] && fail "a refused synthesis left something"
done
echo "quilt previews: each within what it was given"
