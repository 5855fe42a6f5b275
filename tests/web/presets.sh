#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The presets of the page's wizard and the plans that lie here, against every board: no browser, no box.
. "$(dirname "$0")/../cli/cli.bash"

cp "$SOURCE/firmware/web/presets.js" "$SOURCE/tests/web/presets.mjs" . || exit 1
echo '{"type": "module"}' >package.json
node presets.mjs "$TTFBOX" "$SOURCE" || exit 1
