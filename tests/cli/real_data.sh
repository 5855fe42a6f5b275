#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Real sequences that nobody here made: imported, verified, quilted, checked.
. "$(dirname "$0")/cli.bash"

if [ ! -d "$DATA/timelapse/copper" ]; then
    echo "$DATA is not there (TTFBOX_TEST_DATA names another place): skipped"
    exit 77
fi

real() { # NAME SIZE BLOCK EXTRA...
    local name=$1 size=$2 block=$3
    shift 3
    expect 0 "$TTFBOX" import "$DATA/timelapse/$name"/*.png --interval 1min -o "$name"
    expect 0 "$TTFBOX" verify "$name"
    expect 0 "$TTFBOX" synth quilt "$name" --size "$size" --block "$block" --check -o "$name-q" --json "$@"
    is unmatched_pixels 0
    echo "$name: coherence $(json report.coherence) of the whole input"
    expect 0 "$TTFBOX" verify "$name-q"
    expect 1 "$TTFBOX" synth quilt "$name" --size "$size" --block "$block" --per-frame --check \
        --frames 6 -o "$name-f" --json
    [ "$(json unmatched_pixels)" -gt 0 ] || fail "$name: quilting each frame alone passes the check"
    rm -rf "$name" "$name-q" "$name-f"
}
real copper 512x512 64x64
real clay 512x512 64x64
real banana 800x600 64x64 --frames 6
