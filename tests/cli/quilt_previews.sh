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
within 33 --size 96x96 --per-frame # what one frame took is there for the next
within 60
plain=$(json preview.estimated_bytes)
within 60 --agreement 2
holds "$(json preview.estimated_bytes) >= $plain + 3 * 12 * 256 * 256"
expect 2 "$TTFBOX" synth quilt l --block 32x32 --sink null --agreement 2 --memory 16MiB
said err "16 MiB are allowed"
said err "do without the comparison"
expect 0 "$TTFBOX" synth quilt l --block 32x32 --sink null --memory 16MiB

# ---- what is told in frames is of frames kept, what is told in pixels of pixels kept ----
# every second frame of 16 keeps within the time, and so do all pixels
expect 0 "$TTFBOX" synth quilt d --block 32x32 --size 2560x1920 --sink null --preview --memory 1GiB --time 4s --jitter 4 --json
is preview.shrunk_by 1
is preview.frame_step 2
is report.parameters.jitter_frames 2
is report.parameters.jitter_every 8
expect 0 "$TTFBOX" synth quilt d --block 32x32 --size 2560x1920 --sink null --preview --memory 1GiB --time 3s --deflicker --json
is preview.frame_step 2
gain=$(json report.prepared.largest_gain)
expect 0 "$TTFBOX" synth quilt d --source d --block 32x32 --size 2560x1920 --sink null --preview --memory 1GiB --time 3500ms --deflicker --json
is preview.frame_step 2
is report.sources.1.prepared.largest_gain "$gain" # the same pictures: the same window
mkdir half && for i in 0 2 4 6 8 10 12 14; do cp in/p$i.png half/; done
expect 0 "$TTFBOX" import half/*.png --interval 2min -o half-d
expect 0 "$TTFBOX" synth quilt half-d --block 16x16 --sink null --deflicker --deflicker-window 5 --json
is report.prepared.largest_gain "$gain"

frames picture photo photo.png 240 192
mkdir grey && for i in 0 1 2 3 4 5 6 7; do frames picture plain grey/$i.png 60 48; done
expect 0 "$TTFBOX" import grey/*.png --interval 1min -o g
expect 0 "$TTFBOX" synth composite photo.png g --block 16x16 --size 720x576 --sink raw -o small.rgb --soften 6 --preview --time 100ms --json
shrunk=$(json preview.shrunk_by)
[ "$shrunk" -ge 2 ] || fail "the composite is no smaller"
expect 0 "$TTFBOX" synth composite photo.png g --block $((16 / shrunk))x$((16 / shrunk)) --size $((720 / shrunk))x$((576 / shrunk)) \
    --sink raw -o same.rgb --soften "$(awk "BEGIN { print 6 / $shrunk }")"
cmp small.rgb same.rgb || fail "a shrunk object's edge is as wide as the whole one's"

# ---- a time that cannot be kept is gone beyond, not in silence ----
preview --size 96x64 --time 1h
[ -s "$WORK/err" ] && fail "a warning for an hour"
is report.prepared.preview_within_time true
preview --size 2000x1500 --memory 1GiB --time 100ms
said err "--time: no preview is estimated to take 0.1 s"
is report.prepared.preview_within_time false
is report.prepared.preview_allowed_ns 100000000

# ---- so is an error that no rank reaches ----
expect 0 "$TTFBOX" synth quilt d --block 16x16 --sink null --rank-error 20 --json
[ -s "$WORK/err" ] && fail "a warning for an error that is reached"
is report.compression.error_reached true
mkdir noisy && frames noise noisy 40 48 40
expect 0 "$TTFBOX" import noisy/*.png --interval 1min -o noise
expect 0 "$TTFBOX" synth quilt noise --block 16x16 --sink null --rank-error 0.1 --json
said err "--rank-error: rank 64"
is report.compression.error_reached false
is report.compression.error_wanted 0.001
expect 0 "$TTFBOX" synth quilt d --block 16x16 --sink null --json
grep -q error_wanted "$WORK/out" && fail "no error was wanted"

for left in never never.csv never.svg; do
    [ -e $left ] && fail "a refused synthesis left something"
done
echo "quilt previews: each within what it was given"
