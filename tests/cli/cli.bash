# SPDX-License-Identifier: Apache-2.0
# What the scripts here share. Sourced, not run. Each script works in a temporary
# folder that is removed at its end, and ends with 1 at the first thing that is not so.
set -uo pipefail

: "${TTFBOX:?the program to test}" "${SOURCE:?the source folder}" "${PYTHON:=python3}"
HERE=$SOURCE/tests/cli
PLANS=$SOURCE/boards/sim/plans
DATA=${TTFBOX_TEST_DATA:-$SOURCE/../shared/data}

WORK=$(mktemp -d "${TMPDIR:-/tmp}/ttfbox-cli.XXXXXX")
# What still runs in the background is ended, too: a test that failed would be waited for.
# shellcheck disable=SC2046 # one word a process
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$WORK" ${MEMORY:+"$MEMORY"}' EXIT
cd "$WORK" || exit 1

fail() {
    echo "FAILED: $*" >&2
    for f in out err; do
        [ -s "$WORK/$f" ] && { echo "--- $f:"; head -c 4000 "$WORK/$f"; } >&2
    done
    exit 1
}

# expect CODE COMMAND...: its output is in $WORK/out and $WORK/err.
expect() {
    local code=$1 got
    shift
    "$@" >"$WORK/out" 2>"$WORK/err"
    got=$?
    [ "$got" = "$code" ] || fail "exit $got instead of $code: $*"
}

# said FILE WORDS: the words stand in out or err.
said() {
    grep -qF -- "$2" "$WORK/$1" || fail "$1 does not say '$2'"
}

# json KEY: a top-level value of the last line of out.
json() {
    tail -n 1 "$WORK/out" | "$PYTHON" -I -S -c 'import json,sys
v = json.load(sys.stdin)
for k in sys.argv[1].split("."):
    v = v[int(k)] if isinstance(v, list) else v[k]
print(str(v).lower() if isinstance(v, bool) else v)' "$1" || fail "no '$1' in the JSON"
}

# is KEY VALUE: of the JSON in out.
is() {
    local got
    got=$(json "$1")
    [ "$got" = "$2" ] || fail "'$1' is '$got' instead of '$2'"
}

# A box of a few pixels, so that a whole capture takes a moment.
TINY=(--board sim-small --set sim.sensor.width=96px --set sim.sensor.height=64px)

# plan FILE LINE...: writes a plan.
plan() {
    local file=$1
    shift
    printf '%s\n' "$@" >"$file"
}

# sanitized PROGRAM: it was built with a sanitizer, which looks for leaks itself and keeps what was freed.
sanitized() {
    grep -qaE '__(asan|tsan)_init' "$1"
}
