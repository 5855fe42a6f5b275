#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Kept factors are gone on with where the input is the one they know, and begun anew where it was prepared otherwise.
. "$(dirname "$0")/cli.bash"

# quilt INPUT FILE OPTIONS...: nothing kept but the factors in FILE; JSON in out.
quilt() {
    local input=$1 file=$2
    shift 2
    expect 0 "$TTFBOX" synth quilt "$input" --block 16x16 --sink null --factors "$file" --json "$@"
}

# known N WORDS: so many frames were known, and standard error has the words ("": nothing at all).
known() {
    is report.compression.frames_known_before "$1"
    if [ "$2" ]; then said err "$2"; else [ ! -s "$WORK/err" ] || fail "a warning: $(cat "$WORK/err")"; fi
}

mkdir in
"$PYTHON" "$HERE/pictures.py" make in 16 60 48 || fail "making pictures"
expect 0 "$TTFBOX" import in/*.png --interval 1min -o d
expect 0 "$TTFBOX" import in/p[0-9].png --interval 1min -o d10 # its first ten
mkdir nudged && "$PYTHON" "$HERE/frames.py" nudged nudged 12 64 48
expect 0 "$TTFBOX" import nudged/*.png --interval 1min -o n
expect 0 "$TTFBOX" import nudged/n[0-2].png --interval 1min -o n3 # before the first nudge
# A dataset that grows keeps its uuid.
for pair in d:d10 n:n3; do
    "$PYTHON" - "${pair%:*}" "${pair#*:}" <<'END' || fail "no common uuid"
import json, sys
grown, young = (json.load(open(f"{name}/dataset.json"))["uuid"] for name in sys.argv[1:])
path = sys.argv[2] + "/dataset.json"
text = open(path).read()
assert young in text
open(path, "w").write(text.replace(young, grown))
END
done

# ---- as it is: gone on with ----
quilt d10 plain
known 0 ""
quilt d plain
known 10 ""
quilt d plain
known 16 ""

# ---- what looks at all frames makes another input of one that grew ----
quilt d10 flat --flatten
quilt d10 flat --flatten
known 10 ""
quilt d flat --flatten
known 0 "begun anew"
said err "flattened by 8 px"
quilt d flat --flatten
known 16 ""
quilt n3 steady --stabilise
quilt n steady --stabilise
known 0 "stabilised"

# ---- prepared otherwise: what was learnt of the input as it is stays ----
cp plain kept
quilt d plain --flatten
known 0 "knows the input, as it is; now it is taken, flattened by 8 px: begun anew, and the file is left as it is"
quilt d flat --flatten --flatten-sigma 4
known 0 "flattened by 8 px; now it is taken, flattened by 4 px"
quilt d plain --preview --size 720x576 --memory 24MiB
known 0 "left as it is"
cmp plain kept || fail "a preview took what a whole run had learnt"
quilt d plain
known 16 ""

# ---- previews keep to what is known, where that is within what they may take ----
quilt d10 look --preview --size 720x576 --memory 24MiB
shrunk=$(json preview.shrunk_by)
[ "$shrunk" -ge 2 ] || fail "the preview is no smaller"
quilt d look --preview --size 720x576 --memory 1GiB --time 1h
is preview.shrunk_by "$shrunk"
known 10 ""
quilt d look --preview --size 1440x1152 --memory 24MiB --time 1h
[ "$(json preview.shrunk_by)" -gt "$shrunk" ] || fail "a preview takes more than it may"
known 0 "shrunk by $shrunk, one frame of 1"
quilt d look
known 0 "left as it is"

# ---- what is no such thing is refused as ever ----
expect 2 "$TTFBOX" synth quilt d10 --block 16x16 --sink null --flatten --factors flat
said err "they are of 16 frames"
mkdir other && "$PYTHON" "$HERE/frames.py" nudged other 16 60 48
expect 0 "$TTFBOX" import other/*.png --interval 1min -o o
expect 2 "$TTFBOX" synth quilt o --block 16x16 --sink null --factors plain
said err "they belong to another dataset"
cp flat kept
expect 2 "$TTFBOX" synth quilt o --block 16x16 --sink null --flatten --factors flat
said err "they belong to another dataset"
cmp flat kept || fail "another dataset took them"
echo "quilt factors: each gone on with, begun anew or refused"
