#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# 8-bit sRGB pictures imported and exported again are the same to the bit.
. "$(dirname "$0")/cli.bash"

mkdir in
"$PYTHON" "$HERE/pictures.py" make in 12 40 30 || fail "making pictures"

expect 2 "$TTFBOX" import in/*.png -o d
said err "--interval"
expect 0 "$TTFBOX" import in/*.png --interval 1min -o d --json
is frames 12
is width 40
expect 0 "$TTFBOX" verify d
expect 0 "$TTFBOX" info d --json
is simulated false
is slots 12
is interval_ns 60000000000
expect 0 "$TTFBOX" export d --to png -o back
n=1001
for i in $(seq 0 11); do # natural order: p2 before p10
    "$PYTHON" "$HERE/pictures.py" same "in/p$i.png" "back/frame.$n.png" || fail "p$i.png came back otherwise"
    n=$((n + 1))
done

mkdir disk && ln -s disk link
expect 0 "$TTFBOX" export d --to png --start 0 -o link
[ -L link ] || fail "a link was replaced"
[ -s disk/frame.0000.png ] || fail "not where the link leads, or not from 0: $(ls disk)"
ln -s nowhere dangling
expect 2 "$TTFBOX" export d --to png -o dangling
said err "dangling: is a link that leads nowhere"
[ "$(readlink dangling)" = nowhere ] || fail "a link was replaced"

# Every pixel of a quilted sequence lives the life of one source pixel; each frame alone does not.
expect 0 "$TTFBOX" synth quilt d --size 64x48 --block 12x12 --check -o q --json
is unmatched_pixels 0
is checked_pixels $((64 * 48))
expect 1 "$TTFBOX" synth quilt d --size 64x48 --block 12x12 --per-frame --check -o qf --json
[ "$(json unmatched_pixels)" -gt 0 ] || fail "the check bites nothing"

# What is slow in the picture, unless said otherwise: half the larger side of a block.
for sigma in 6 12; do
    expect 0 "$TTFBOX" synth quilt d --size 64x48 --block 12x10 --flatten --flatten-sigma $sigma --sink raw -o s$sigma.rgb
done
expect 0 "$TTFBOX" synth quilt d --size 64x48 --block 12x10 --flatten --sink raw -o s.rgb
cmp -s s.rgb s6.rgb || fail "not half a block"
cmp -s s.rgb s12.rgb && fail "any sigma gives the same"

expect 2 "$TTFBOX" import in/*.png --interval 1min -o d
said err "exists already"
rm in/p5.png && printf 'no picture' >in/p5.png
expect 2 "$TTFBOX" import in/*.png --interval 1min -o e
said err "in/p5.png"
[ -e e ] && fail "a failed import left something"
echo "exact: to the bit"
