#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What the page makes of the box's answers, without a browser.
. "$(dirname "$0")/../cli/cli.bash"

cp "$SOURCE"/firmware/web/*.js "$SOURCE/firmware/view/page/plot.js" . || exit 1
echo '{"type": "module"}' >package.json
cp "$SOURCE/tests/web/box.mjs" . || exit 1
node box.mjs || exit 1
