#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Real sequences that nobody here made: imported, verified, quilted, checked.
. "$(dirname "$0")/cli.bash"

if [ ! -d "$DATA/timelapse/copper" ]; then
    echo "$DATA is not there (TTFBOX_TEST_DATA names another place): skipped"
    exit 77
fi

real() { # NAME SIZE: of the dataset NAME that lies here
    local name=$1 size=$2
    expect 0 "$TTFBOX" verify "$name"
    expect 0 "$TTFBOX" synth quilt "$name" --size "$size" --check -o "$name-q" --json
    is unmatched_pixels 0
    echo "$name: coherence $(json report.temporal_coherence.difference_ratio) of the whole input"
    expect 0 "$TTFBOX" verify "$name-q"
    # The baseline fails the same check: each frame quilted alone copies no trajectory.
    expect 1 "$TTFBOX" synth quilt "$name" --size "$size" --per-frame --check --frames 4 -o "$name-f" --json
    [ "$(json unmatched_pixels)" -gt 0 ] || fail "$name: quilting each frame alone passes the check"
    rm -rf "$name-q" "$name-f"
}
for name in copper clay; do
    expect 0 "$TTFBOX" import "$DATA/timelapse/$name"/*.png --interval 1min -o "$name"
    real "$name" 512x512
    # Light that is uneven has one spot laid everywhere: said, with what helps; and not of what is even.
    expect 0 "$TTFBOX" synth quilt "$name" --size 512x512 -o again
    said out "the same place again and again; try --flatten (light that is uneven) and --avoid 64"
    expect 0 "$TTFBOX" synth quilt "$name" --size 512x512 --flatten --avoid 64 -o even
    grep -q "^repetition  .*% of the input is used" out || fail "nothing is said of repetition: $(cat out)"
    grep -q "again and again" out && fail "a hint that was followed is given again: $(cat out)"
    rm -rf again even
done

# Bananas are large: verified as they are, quilted a quarter as wide.
expect 0 "$TTFBOX" import "$DATA/timelapse/banana"/*.png --interval 1d -o large
expect 0 "$TTFBOX" verify large
expect 0 "$TTFBOX" export large --to png --width 372 -o small
expect 0 "$TTFBOX" import small/*.png --interval 1d -o banana
real banana 512x384
echo "real data: every trajectory is one source pixel's, to the bit"
