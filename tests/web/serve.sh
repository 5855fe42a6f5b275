#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The page of `ttfbox serve`, in a browser: what people wrote, ten thousand slots, a dataset that grows. TTFBOX_SHOTS: a folder for pictures.
. "$(dirname "$0")/../cli/cli.bash"

plan p.yaml 'title: "Grass <img src=x onerror=alert(1)> & a-title-with-a-part-that-has-no-place-to-break-it-anywhere_at_all_0123456789"' \
    'interval: 1h' 'count: 3' 'lamps: {mode: continuous}' 'shots:' \
    '  - {stream: main, channel: white, lamps: {left: 100%, right: 100%}, exposure: 20ms}' 'mains: 50Hz' 'keep: developed'
mkdir data
expect 0 "$TTFBOX" capture p.yaml "${TINY[@]}" -o data/grass
cp -r data/grass data/a-name-that-is-as-long-as-names-of-datasets-may-be_0123456789.ab
expect 0 "$TTFBOX" note data/grass "first line <b>not bold</b>
second line, and $(printf 'x%.0s' $(seq 400))" --author 'Jo <script>alert(1)</script>' --tag exclude --slots 1
"$PYTHON" "$HERE/many_slots.py" data/grass data/long 10000 --files --missed 3 || fail "they cannot be made"
"$PYTHON" "$HERE/many_slots.py" data/grass all 30 --files || fail "they cannot be made"
node "$SOURCE/tests/web/serve.mjs" "$TTFBOX" ${TTFBOX_SHOTS:+"$TTFBOX_SHOTS"} || exit 1
