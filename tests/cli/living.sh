#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs that are changed while they live, by a script; notes; and a run that goes on in a second storage.
. "$(dirname "$0")/cli.bash"

mkdir second
plan p.yaml "interval: 1min" "count: 8" "lamps: {mode: capture-only, settle: 5s}" \
    "shot: {lamps: {left: 100%}}" "storage: {second: $WORK/second}"

# ---- asked by a script, gone on with by the first plan ----
printf '%s\n' "# meanwhile" "" "2 pause watering" "3 continue" "4 interval 30s" "4 note faster now" \
    "5 count 10" "7 stop" >script
expect 1 "$TTFBOX" capture p.yaml "${TINY[@]}" -o grass --script script --json
is slots 7
is paused 1
is sealed false
expect 0 "$TTFBOX" capture p.yaml "${TINY[@]}" -o grass --json
is slots 10
is plan_left_alone true
is sealed true
is second_storage false
grep -q '"text":"faster now"' grass/notes.jsonl || fail "the note is not there"
[ -f grass/plans/2.json ] || fail "two changes are two plans"
echo "3 dance" >wrong
expect 2 "$TTFBOX" capture p.yaml "${TINY[@]}" -o other --script wrong
said err "wrong:1"

printf '2 dance' >wrong
expect 2 "$TTFBOX" capture p.yaml "${TINY[@]}" -o other --script wrong
said err "no word 'dance'"
expect 2 "$TTFBOX" capture p.yaml "${TINY[@]}" -o other --script <(echo "2 stop")
said err "no plain file"
printf '2 note %s\n' "$(printf 'x%.0s' $(seq 1024))" >wrong
expect 2 "$TTFBOX" capture p.yaml "${TINY[@]}" -o other --script wrong
said err "wrong:1: a text of at most 1023 bytes is meant"
printf '2 pause %s\n' "$(printf 'x%.0s' $(seq 120))" >wrong
expect 2 "$TTFBOX" capture p.yaml "${TINY[@]}" -o other --script wrong
said err "wrong:1: a text of at most 119 bytes is meant"
[ ! -e other ] || fail "a refused capture left something"

# ---- what is refused while it runs, or never heard, is told ----
printf '2 count 1\r\n99 note late\n' >refused
expect 1 "$TTFBOX" capture p.yaml "${TINY[@]}" -o refused.d --script refused --json
said err "refused:1: refused: 2 slots have their records already"
said err "refused:2: the run ended before it was heard"
is sealed true
is script_lines_not_done 2

# ---- until an instant, with whatever interval ----
printf '2 until 2026-03-01T08:05:00Z\n2 interval 30s\n' >until
expect 0 "$TTFBOX" capture p.yaml "${TINY[@]}" -o until.d --script until --json
is slots 9
is sealed true
grep -q '"type":"end".*"reason":"until"' until.d/records.jsonl || fail "the end does not say what ended it"
echo "2 until tomorrow" >wrong
expect 2 "$TTFBOX" capture p.yaml "${TINY[@]}" -o other --script wrong
said err "wrong:1"

# ---- another stream: a dataset of its own, in the group ----
plan infrared.yaml "interval: 1min" "count: 2" "lamps: {mode: capture-only, settle: 5s}" \
    "shot: {stream: infrared, lamps: {left: 100%}}"
expect 2 "$TTFBOX" capture infrared.yaml "${TINY[@]}" -o until.d
said err "group: NAME-OF-THIS-ONE"
echo "group: nowhere" >>infrared.yaml
expect 2 "$TTFBOX" capture infrared.yaml "${TINY[@]}" -o infrared.d
said err "infrared.yaml:5:8: group: there is no dataset 'nowhere' beside infrared.d"
[ ! -e infrared.d ] || fail "a refused capture left something"
sed -i 's/nowhere/until.d/' infrared.yaml
expect 0 "$TTFBOX" capture infrared.yaml "${TINY[@]}" -o infrared.d
expect 0 "$TTFBOX" info until.d --json
OF=$(json uuid)
expect 0 "$TTFBOX" info infrared.d --json
is group_uuid "$OF"
is group_member 2
expect 0 "$TTFBOX" verify infrared.d

# ---- a stop is for once; a plan cannot end before what there is ----
echo "4 stop" >stop
expect 1 "$TTFBOX" capture p.yaml "${TINY[@]}" -o stops --script stop
plan shorter.yaml "interval: 1min" "count: 2" "lamps: {mode: capture-only, settle: 5s}" \
    "shot: {lamps: {left: 100%}}" "storage: {second: $WORK/second}"
expect 2 "$TTFBOX" capture shorter.yaml "${TINY[@]}" -o stops
said err "the dataset has 4 already"
expect 0 "$TTFBOX" capture p.yaml "${TINY[@]}" -o stops --script stop --json
is slots 8

# ---- notes, outside the seal ----
expect 0 "$TTFBOX" note grass "all \"well\"" --slots 2-3,5 --tag exclude,mine --author Jo
tail -n 1 grass/notes.jsonl | "$PYTHON" -c 'import json, sys
v = json.load(sys.stdin)
assert v["text"] == "all \"well\"" and v["slots"] == [[2, 3], [5, 5]], v
assert v["tags"] == ["exclude", "mine"] and v["author"] == "Jo", v' || fail "the note is another one"
expect 2 "$TTFBOX" note grass "wrong" --slots 5-2
expect 2 "$TTFBOX" note grass "too far" --slots 9-10
said err "its last slot is 9"
expect 2 "$TTFBOX" note grass --tag "two words"
expect 0 "$TTFBOX" info grass
said out "note              slots 2-3,5: all"
said out "interval          30s from slot 4 on"
said out 'all "well" [exclude, mine] -- Jo'
expect 0 "$TTFBOX" note grass --slots 4 --tag wet,cold
expect 0 "$TTFBOX" info grass
said out "note              slots 4: [wet, cold]"
expect 0 "$TTFBOX" export grass -o grass.y4m
said out "excluded          2 slots"
expect 2 "$TTFBOX" note grass
expect 0 "$TTFBOX" verify grass
# Somebody else is at it: waited for, if it does not take too long.
mkfifo gate
flock grass/dataset.json sh -c 'echo > gate; sleep 0.5' &
read -r _ < gate
expect 0 "$TTFBOX" note grass "after the other"
wait
flock -F grass/dataset.json sh -c 'echo > gate; exec sleep 30' &
read -r _ < gate
expect 1 "$TTFBOX" note grass "too long"
said err "another note is being written"
kill $!

# ---- samples, outside the seal ----
expect 0 "$TTFBOX" sample grass A1 --region 0,0,48x32 --title "Lolium perenne"
expect 0 "$TTFBOX" sample grass A1 --treatment "dry since 4"
printf '\357\273\277id,species,x,y,width,height\r\nA2,"Poa, annua",48,0,48,32\r\n\r\nA3,,0,32,96,32\r\n' >pots.csv
expect 0 "$TTFBOX" sample grass --table pots.csv --json
is samples 2
is samples_now 3
expect 0 "$TTFBOX" sample grass --table pots.csv
said out "samples           2 set, 3 now in grass/samples.json"
expect 0 "$TTFBOX" info grass
said out "sample A1         48 x 32 at 0, 0, Lolium perenne, dry since 4"
said out "sample A2         48 x 32 at 48, 0, Poa, annua"
said out "sample A3         96 x 32 at 0, 32"
# What a cell does not say stays as it was; a row that says nothing is none.
printf 'id;treatment;title;x;y;width;height\r\nA1;;;0;0;40;32\r\nA2;"wet";;;;;\r\n;;;;;;\r\n' >pots.csv
expect 0 "$TTFBOX" sample grass --table pots.csv --json
is samples 2
expect 0 "$TTFBOX" info grass
said out "sample A1         40 x 32 at 0, 0, Lolium perenne, dry since 4"
said out "sample A2         48 x 32 at 48, 0, Poa, annua, wet"
printf 'id;x;y;width;height\n;0;0;8;8\n' >pots.csv
expect 2 "$TTFBOX" sample grass --table pots.csv
said err "a sample without an id"
expect 0 "$TTFBOX" sample grass A1 --title ""
expect 0 "$TTFBOX" info grass
said out "sample A1         40 x 32 at 0, 0, dry since 4"
expect 0 "$TTFBOX" sample grass A1 --treatment ""
expect 0 "$TTFBOX" info grass
if grep -q "Lolium\|dry since" out; then fail "an empty text takes nothing back: $(cat out)"; fi
expect 0 "$TTFBOX" sample grass A3 --remove
said out "samples           1 removed, 2 now in"
expect 0 "$TTFBOX" verify grass
expect 2 "$TTFBOX" sample grass
expect 2 "$TTFBOX" sample grass A1
expect 2 "$TTFBOX" sample grass A4 --title "a new one without a region"
said err "needs a region"
expect 2 "$TTFBOX" sample grass A4 --region 90,0,48x32
said err "outside of the picture, which has 96 x 64 pixels"
expect 2 "$TTFBOX" sample grass A4 --region 90,0,48
expect 2 "$TTFBOX" sample grass A1 --remove --title x
expect 2 "$TTFBOX" sample grass A1 --table pots.csv
expect 2 "$TTFBOX" sample grass A9 --remove
printf 'id,x,y,width,height\nB1,0,0,8,8\nB2,0,0,8,1e1\n' >pots.csv
expect 2 "$TTFBOX" sample grass --table pots.csv
said err "line 3"
printf 'id,colour\nB1,red\n' >pots.csv
expect 2 "$TTFBOX" sample grass --table pots.csv
said err "no column 'colour'"
[ "$(grep -c '"id"' grass/samples.json)" = 2 ] || fail "what was refused was written all the same"

# ---- the second storage ----
expect 0 "$TTFBOX" plan check p.yaml "${TINY[@]}" -o moved
said err "same file system"
said out "second storage    $WORK/second"
READ_ONLY=(--set 'sim.faults=[{kind: read-only, at: 4min, target: first}]')
expect 0 "$TTFBOX" capture p.yaml "${TINY[@]}" "${READ_ONLY[@]}" -o moved --json
is second_storage true
said err "goes on here"
expect 0 "$TTFBOX" verify second/moved
expect 0 "$TTFBOX" verify moved
expect 0 "$TTFBOX" capture p.yaml "${TINY[@]}" "${READ_ONLY[@]}" -o moved --json
is already_complete true
for word in info verify; do
    expect 0 "$TTFBOX" "$word" moved
    said out "goes on in        $WORK/second/moved"
done
mv second second.away
expect 0 "$TTFBOX" info moved
said out "may have gone on in it"
expect 2 "$TTFBOX" capture p.yaml "${TINY[@]}" -o moved
said err "may have gone on in it"
mv second.away second
expect 2 "$TTFBOX" capture p.yaml "${TINY[@]}" -o second/beside
said err "the folder that the dataset itself lies in"
[ ! -e second/beside ] || fail "a refused capture left something"
rm -r second
expect 2 "$TTFBOX" plan check p.yaml "${TINY[@]}"
said err "p.yaml:5:"
said err "storage.second"

# ---- a disk that fills up: capture stops before the reserve, nothing fails ----
plan full.yaml "interval: 1min" "count: 6" "shot: {exposure: 20ms}" "reserve: 200MiB"
expect 0 "$TTFBOX" capture full.yaml "${TINY[@]}" -o full --json \
    --set 'sim.faults=[{kind: disk-full, at: 150s, for: 1h, amount: 100}]'
is failed 0
[ "$(json missed)" -ge 2 ] || fail "the reserve was not kept"
expect 0 "$TTFBOX" verify full
echo "living: all as it should be"
