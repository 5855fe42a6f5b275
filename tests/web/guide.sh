#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The page's calibration guide, plan form and boards on a simulated box, in a browser. TTFBOX_SHOTS: a folder for pictures of what was seen.
. "$(dirname "$0")/../cli/cli.bash"
: "${DAEMON:?the daemon to test}"

node "$SOURCE/tests/web/guide.mjs" "$DAEMON" "$TTFBOX" ${TTFBOX_SHOTS:+"$TTFBOX_SHOTS"} || {
    tail -n 20 daemon.log >&2
    exit 1
}
