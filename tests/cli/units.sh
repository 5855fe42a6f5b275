#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The services as systemd reads them: nothing unknown, nothing missing, little exposed, never given up.
. "$(dirname "$0")/cli.bash"
command -v systemd-analyze >/dev/null || { echo "skipped: no systemd-analyze here"; exit 77; }
: "${UNITS:?the folder of units}" "${BIN:?the folder of programs}"

for unit in ttfboxd ttfbox-lampd ttfbox-usbd ttfbox-carrier ttfbox-preview ttfbox-alertd; do
    # Where they will be installed, nothing is yet.
    bin=$BIN program=$unit
    [ $unit != ttfbox-carrier ] || { bin=$SOURCE/firmware/gadget; program='ttfbox-gadget watch'; }
    sed "s|^ExecStart=[^ ]*/|ExecStart=$bin/|" "$UNITS/$unit.service" >"$unit.service"
    grep -qE "^ExecStart=$bin/$program( |$)" "$unit.service" || fail "$unit starts something else"
    grep -q '^Restart=always' "$unit.service" || fail "$unit is not started again"
    grep -q '^StartLimitIntervalSec=0' "$unit.service" || fail "$unit is given up"
    # The clock asks /proc/sys for the boot's id: where that is hidden the service ends at once, for ever.
    if grep -q '^ProcSubset=pid' "$unit.service" && grep -qa 'kernel/random/boot_id' "$bin/${program%% *}"; then
        fail "$unit is to tell the boot and cannot see /proc/sys"
    fi
done
systemd-analyze --version | head -n 1
# Root's one-shot, apart: it mounts and loads modules, so that little can be taken from it.
sed "s|=[+]*[^ ]*/ttfbox-gadget|=$SOURCE/firmware/gadget/ttfbox-gadget|" "$UNITS/ttfbox-gadget.service" >ttfbox-gadget.service
sed -i "s|=[+]*[^ ]*/ttfbox-gadget |=+$SOURCE/firmware/gadget/ttfbox-gadget |" ttfbox-usbd.service
SYSTEMD_UNIT_PATH=$WORK: systemd-analyze verify --man=no ./ttfbox-gadget.service >out 2>&1 || fail "systemd does not like ttfbox-gadget"
grep -E "ttfbox-gadget\.service" out && fail "systemd has something to say of ttfbox-gadget"
systemd-analyze security --offline=true ./ttfbox-gadget.service 2>&1 | tail -n 1
for unit in ttfboxd ttfbox-lampd ttfbox-usbd ttfbox-carrier ttfbox-preview ttfbox-alertd; do
    SYSTEMD_UNIT_PATH=$WORK: systemd-analyze verify --man=no "./$unit.service" >out 2>&1 ||
        fail "systemd does not like $unit"
    grep -E "$unit\.service" out && fail "systemd has something to say of $unit"
    systemd-analyze security --offline=true --threshold=25 "./$unit.service" >out 2>&1 ||
        fail "$unit is exposed"
    tail -n 1 out
done

# Between services systemd shares the processor by weight: the guardian first, then the daemon, previews last.
weight() { # UNIT: 100 if it says nothing
    sed -n 's/^CPUWeight=//p; $s/.*/100/p' "$UNITS/$1.service" | head -n 1
}
for unit in ttfbox-usbd ttfbox-alertd; do
    [ "$(weight ttfboxd)" -ge $((10 * $(weight $unit))) ] || fail "$unit can delay a slot"
    [ "$(weight ttfbox-preview)" -lt "$(weight $unit)" ] || fail "previews can delay $unit"
done
[ "$(weight ttfbox-lampd)" -gt "$(weight ttfboxd)" ] || fail "the daemon can delay the guardian"

# A restart of the cable's service is no unplugging: its manager keeps ep0, and what follows an end asks whether it was a stop.
for line in 'FileDescriptorStoreMax=1' 'NotifyAccess=all'; do
    grep -qx "$line" "$UNITS/ttfbox-usbd.service" || fail "ttfbox-usbd.service lacks $line"
done
grep -qE '^ExecStopPost=\+.*/ttfbox-gadget stopped$' "$UNITS/ttfbox-usbd.service" || fail "ttfbox-usbd.service unbinds at each restart"
grep -qE 'ttfbox-gadget( .*)? unbind' "$UNITS/ttfbox-usbd.service" && fail "ttfbox-usbd.service unbinds at each restart"

# A box's image has each of them on, as its board says (image_services.sh); the cable's where the board's port is a PC's device.
"$TTFBOX" board show --board "$SOURCE/boards/rpi4" >shown || fail "no board says what it runs"
grep -qx 'Wants=ttfbox-carrier.service' "$UNITS/ttfbox-usbd.service" || fail "nothing starts ttfbox-carrier"
for unit in "$UNITS"/*.service; do
    [ "$(basename "$unit")" != ttfbox-carrier.service ] || continue # the cable's wants it
    sed -n 's/^units //p' shown | tr ' ' '\n' | grep -qx "$(basename "$unit" .service)" ||
        fail "images leave $(basename "$unit") off"
    # The cable's service reads no settings.
    [ "$(basename "$unit")" != ttfbox-usbd.service ] || continue
    grep -E '^Before=' "$SOURCE/firmware/image/root/etc/systemd/system/ttfbox-settings.service" | grep -qw "$(basename "$unit")" ||
        fail "images start $(basename "$unit") before its settings are there"
done

# A stop is given the time to store what waits for a slow card, a minute for each picture beside 5 min for a slot; a power-off gives up after 30 min.
pictures=$(sed -n 's/^#define TTF_QUEUE_RAW_MOST  *\([0-9]*\)$/\1/p' "$SOURCE/capture/queue.h")
patience_s=$(systemd-analyze timespan "$(sed -n 's/^TimeoutStopSec=//p' ttfboxd.service)" | awk 'NR == 2 {print int($2 / 1000000)}')
[ "${patience_s:-0}" -ge $((300 + 60 * ${pictures:?how many pictures may wait})) ] || fail "a stop is cut short with $pictures pictures that wait"
[ "$patience_s" -lt 1800 ] || fail "a power-off is cut short by a stop"

# The guardian's watchdog is longer than its round, the daemon's than what its loop arms.
grep -q '^WatchdogSec=20s' ttfboxd.service || fail "less than the loop's 15 s, or nothing"
if command -v systemd-sysusers >/dev/null; then
    mkdir -p root/etc
    expect 0 systemd-sysusers --root="$WORK/root" "$SOURCE/firmware/units/ttfbox.sysusers"
    grep -q '^ttfbox-lampd:' root/etc/passwd || fail "the guardian has no user"
fi
