#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A dataset as one HTML file: what it holds, how large it is, what is refused, and that nothing is left half written.
. "$(dirname "$0")/cli.bash"

mkdir in
"$PYTHON" "$HERE/pictures.py" make in 6 60 48 || fail "making pictures"
expect 2 "$TTFBOX" import in/*.png --interval 1min --title "" -o d
said err "--title: is empty"
expect 0 "$TTFBOX" import in/*.png --interval 1min --title '</script><b>A & B' -o d
expect 0 "$TTFBOX" import in/p[0-3].png --interval 90s -o d4

# --- small ones are in it exactly, all of them
expect 0 "$TTFBOX" view d -o v.html --json
is panels.0.frames 6
is panels.0.width 60
is panels.0.exact true
[ "$(json bytes)" = "$(stat -c %s v.html)" ] || fail "it has another size than it says"
"$PYTHON" "$HERE/view_file.py" v.html exact in || fail "the file's pictures are not the dataset's"

# --- two beside each other, each with its own times
expect 0 "$TTFBOX" view d --beside d4 -o both.html --json
is panels.0.role source
is panels.1.role synthesis
is panels.1.frames 4
"$PYTHON" "$HERE/view_file.py" both.html panels 2 || fail "the two are not both there"

# --- fewer frames, smaller pictures
expect 0 "$TTFBOX" view d --frames 3 --width 30 -o small.html --json
is panels.0.frames 3
is panels.0.height 24
"$PYTHON" "$HERE/view_file.py" small.html slots 0 3 5 || fail "the frames are not spread from the first to the last"

# --- the same bytes for any number of threads
expect 0 "$TTFBOX" view d --beside d4 -o both3.html --threads 3
cmp both.html both3.html || fail "another number of threads gives other bytes"

# --- what is refused leaves nothing
touch before
find . -maxdepth 1 | sort >before
refuse() { # CODE WORDS ARGUMENTS...
    local code=$1 words=$2
    shift 2
    expect "$code" "$TTFBOX" view "$@"
    said err "$words"
}
refuse 2 "-o: is missing" d
refuse 2 "exists already" d -o v.html
refuse 2 "lies inside of the dataset" d -o d/v.html
refuse 2 "--frames" d --frames 257 -o never.html
refuse 2 "--width" d --width 4096 -o never.html
refuse 2 "nowhere" nowhere -o never.html
refuse 2 "--beside" d --beside nowhere -o never.html
refuse 2 "no stream" d --stream other -o never.html
refuse 2 "DATASET is missing" -o never.html
find . -maxdepth 1 | sort | diff before - || fail "what was refused left something"

# --- a frame that is damaged ends it, by name, and nothing is left
cp -r d broken
frame=$(find broken/frames -name '000003*')
printf 'no picture' >"$frame"
refuse 3 "000003" broken -o never.html
# --- nor of one that is stopped; and what is somebody else's stays
mkdir noise
"$PYTHON" "$HERE/view_file.py" noise noise 12 640 480 || fail "making noise"
expect 0 "$TTFBOX" import noise/*.png --interval 1min -o n
echo old >stopped.html.tmp
"$TTFBOX" view n -o stopped.html --threads 1 2>stop.err &
pid=$!
for _ in $(seq 500); do
    [ "$(stat -c %s .stopped.html.part-* 2>/dev/null || echo 0)" -gt 100000 ] && break
    sleep 0.01
done
kill -INT "$pid"
wait "$pid"
code=$?
[ "$code" = 1 ] || fail "stopped, it ended with $code"
[ "$(cat stopped.html.tmp)" = old ] || fail "a file of somebody else's is gone"
rm stopped.html.tmp stop.err
[ -z "$(find . -name 'never*' -o -name '*stopped*')" ] || fail "something is left: $(ls -A)"
echo "view: one file, whole or not there"
