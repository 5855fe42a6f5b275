#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What an image enables: what its board names, as the program says it.
. "$(dirname "$0")/cli.bash"

mkdir stubs
cat >stubs/systemctl <<'END'
#!/bin/sh
echo "$*" >>"$TOLD"
END
chmod +x stubs/systemctl
export TOLD=$WORK/told

enabled() { # BOARD LINE...: what systemd is told, and nothing else
    expect 0 "$TTFBOX" board show --board "$SOURCE/boards/$1"
    cp out shown
    rm -f told
    expect 0 env "PATH=$WORK/stubs:$PATH" sh "$SOURCE/firmware/image/services.sh" shown
    printf '%s\n' "${@:2}" >wanted
    diff wanted told >differs || fail "$1: $(cat differs)"
}
always=("enable ttfbox-settings.service" "enable ttfbox-lampd.service" "enable ttfboxd.service" "enable ttfbox-preview.service" "enable ttfbox-alertd.service")
for board in rpi4 rpi5 rpi-zero2w qemu-virt-arm64; do
    enabled $board "${always[@]}" "enable ttfbox-gadget.service" "enable ttfbox-usbd.service"
    # What build.sh looks for, to have the page listen on the cable's network.
    grep -q '^gadget .*network' shown || fail "$board: the cable's network is not seen"
done
enabled pc-uvc "${always[@]}" "mask systemd-networkd.service systemd-networkd.socket"

# --- streams alone: the cable's services, and no network
mkdir alone
sed 's/functions: .*/functions: [streams]}/; s/^board: .*/board: alone/' "$SOURCE/boards/rpi4/board.yaml" >alone/board.yaml
expect 0 "$TTFBOX" board show --board "$WORK/alone"
cp out shown
rm -f told
expect 0 env "PATH=$WORK/stubs:$PATH" sh "$SOURCE/firmware/image/services.sh" shown
said told 'enable ttfbox-usbd.service'
said told 'mask systemd-networkd.service'

# --- a board that names none makes no image
expect 0 "$TTFBOX" board show --board sim
cp out shown
rm -f told
expect 1 env "PATH=$WORK/stubs:$PATH" sh "$SOURCE/firmware/image/services.sh" shown
said err 'names no services'
[ ! -e told ] || fail "something was enabled"

# --- by a configuration: the board that it names, with its changes of it; and nothing beside
printf 'board: rpi4\nset: {gadget.functions: "[streams]"}\n' >box.yaml
mkdir boards
cp -r "$SOURCE/boards/rpi4" boards/
expect 0 "$TTFBOX" board show box.yaml --json
said out '"board":"rpi4","usb":"device","units":["ttfbox-lampd","ttfboxd","ttfbox-preview","ttfbox-alertd","ttfbox-gadget","ttfbox-usbd"],"gadget":["streams"]'
expect 2 "$TTFBOX" board show box.yaml --board sim
said err 'either CONFIG'
expect 2 "$TTFBOX" board show nowhere.yaml
