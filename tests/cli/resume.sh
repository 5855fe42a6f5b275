#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Whatever stops a capture, running it again goes on: no committed slot lost, every
# slot accounted for, verify clean.
. "$(dirname "$0")/cli.bash"

plan week.yaml "interval: 1h" "until: 7d" "lamps: {mode: capture-only, settle: 20s}" \
    "shots: [{lamps: {left: 100%, right: 100%}, exposure: 20ms}]" "keep: both"
SMALL=(--board sim-small)
slots=168

committed() { # DATASET: indices of its records, one per line
    "$PYTHON" - "$1" <<'P'
import json, os, sys
path = os.path.join(sys.argv[1], "records.jsonl")
for line in open(path, "rb").read().split(b"\n")[:-1] if os.path.exists(path) else []:
    v = json.loads(line)
    if v["type"] == "slot":
        print(v["index"])
P
}

# ---- kill -9 at moments that differ ----
kills=0
for delay in 0.05 0.1 0.2 0.3 0.4 0.15 0.25 0.35; do
    committed d >before
    "$TTFBOX" capture week.yaml "${SMALL[@]}" -o d >/dev/null 2>&1 &
    pid=$!
    sleep "$delay"
    kill -9 "$pid" 2>/dev/null && kills=$((kills + 1))
    wait "$pid" 2>/dev/null
    [ -e d/dataset.json ] || continue
    committed d >after
    [ "$(head -n "$(wc -l <before)" after)" = "$(cat before)" ] || fail "a committed slot was lost"
    expect 0 "$TTFBOX" verify d
done
[ "$kills" -ge 3 ] || fail "only $kills of the runs could be killed: the capture is too short"
expect 0 "$TTFBOX" capture week.yaml "${SMALL[@]}" -o d --json
is sealed true
is slots $slots
committed d | "$PYTHON" -c 'import sys
v = [int(x) for x in sys.stdin]
assert v == list(range('$slots')), v' || fail "slots are missing or doubled"
expect 0 "$TTFBOX" verify d --json
is damage 0
is leftover 0
(cd d && sha256sum --strict --quiet -c SHA256SUMS) || fail "sha256sum says otherwise"
echo "resume: $kills kills"

# ---- Ctrl-C ends within a slot, cleanly, and says how to go on ----
"$TTFBOX" capture week.yaml "${SMALL[@]}" -o stopped >out 2>err &
pid=$!
for _ in $(seq 100); do
    [ "$(committed stopped | wc -l)" -ge 3 ] && break
    sleep 0.05
done
kill -INT "$pid"
wait "$pid"
code=$?
[ "$code" = 1 ] || fail "exit $code after an interrupt"
said out "run the same command again"
expect 0 "$TTFBOX" verify stopped --json
is leftover 0
is damage 0
# Before another scene: it is gone on with, and says so.
expect 0 "$TTFBOX" capture week.yaml "${SMALL[@]}" --scene copper -o stopped --json
is sealed true
is resumed true
is slots $slots
grep -q '"kind":"box".*scene copper' stopped/events.jsonl || fail "another scene leaves no event"

# ---- a power cut is part of a simulated run: the box comes back by itself ----
expect 0 "$TTFBOX" capture week.yaml "${SMALL[@]}" -o cut --json \
    --set 'sim.faults=[{kind: power-cut, at: 30h}, {kind: power-cut, at: 50h, amount: 10800}]'
said err "lost power"
is boots 3
is sealed true
is slots $slots
[ "$(json power)" -ge 3 ] || fail "three hours without power are $(json power) slots"
expect 0 "$TTFBOX" verify cut --json
is damage 0

# ---- two captures into one dataset: the second is refused ----
"$TTFBOX" capture week.yaml "${SMALL[@]}" -o both >/dev/null 2>&1 &
pid=$!
for _ in $(seq 100); do
    [ "$(committed both | wc -l)" -ge 1 ] && break
    sleep 0.02
done
"$TTFBOX" capture week.yaml "${SMALL[@]}" -o both >out 2>err
code=$?
wait "$pid" || fail "the first capture did not end well"
[ "$code" = 1 ] || fail "exit $code of the second capture"
expect 0 "$TTFBOX" verify both
echo "resume: after kills, interrupts and power cuts nothing is lost"
