#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# `ttfbox board probe` on a machine made of files, and the bundle for a report.
. "$(dirname "$0")/cli.bash"

cat >box.yaml <<'END'
board: bench
cameras: {main: {backend: v4l2}}
clock: {backend: machine}
lamps: {left: {backend: gpiod, line: GPIO0}}
END
mkdir -p pi/proc/device-tree pi/proc/self pi/dev pi/etc pi/home/anna/.ssh pi/etc/wpa_supplicant
printf 'Raspberry Pi 4 Model B Rev 1.4' >pi/proc/device-tree/model
printf '/dev/mmcblk0p2 / ext4 rw 0 0\n//nas/anna /net cifs rw,username=anna,password=HUSH 0 0\n' >pi/proc/self/mounts
printf 'PASSWORD=HUSH\n' >pi/etc/environment
printf 'psk="HUSH"\n' >pi/etc/wpa_supplicant/wpa_supplicant.conf
printf 'HUSH\n' >pi/home/anna/.ssh/id_ed25519
printf 'PRETTY_NAME="Raspbian"\n' >pi/etc/os-release

# ---- what is wrong, and what to do ----
expect 1 "$TTFBOX" board probe --board ./box.yaml --root pi -o /data
said out "PROBLEM"
said out "camera: the kernel knows no camera"
said out "ribbon cable"
said out "line left: line GPIO0 is also the ID EEPROM of HATs"
said out "memory card (/dev/mmcblk0p2)"
expect 1 "$TTFBOX" board probe --board ./box.yaml --root pi --json
is problems 2
is findings.0.about camera
is findings.0.problem true

# ---- the bundle: all that it names, and nothing else ----
expect 1 "$TTFBOX" board probe --board ./box.yaml --root pi --bundle report.tar.gz
said out "attach it to a report"
tar xzf report.tar.gz || fail "no archive"
(cd ttfbox-report && find . -type f | sort) >members
printf '%s\n' ./BUNDLE.txt ./board.yaml ./devices.txt ./etc/os-release ./mounts.txt ./proc/device-tree/model ./report.json >wanted
diff wanted members >out || fail "other members than those named"
grep -rqE 'HUSH|anna|nas' ttfbox-report && fail "it tells secrets: $(grep -rE 'HUSH|anna|nas' ttfbox-report)"
grep -q '^/dev/mmcblk0p2 / ext4 rw' ttfbox-report/mounts.txt || fail "the mounts are lacking"
cmp box.yaml ttfbox-report/board.yaml || fail "the board is another"
"$PYTHON" -c 'import json; assert json.load(open("ttfbox-report/report.json"))["findings"]' || fail "no report"
expect 2 "$TTFBOX" board probe --board ./box.yaml --root pi --bundle report.tar.gz
said err "exists already"

# ---- devices that do not answer are said one by one ----
expect 1 "$TTFBOX" board probe --board ./box.yaml --set lock=none
said out "camera            DOES NOT ANSWER"
said out "lamps             DOES NOT ANSWER"
said out "is ttfbox-lampd running?"
"$TTFBOX" board probe --board "$SOURCE/boards/rpi4/board.yaml" --set lock=none >out 2>err
grep -q "^panel  *DOES NOT ANSWER" out && said out "door              not known: the panel does not answer"
expect 0 "$TTFBOX" board probe --board sim-small
said out "SIMULATED"
