#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What the kernel is told to be on the bus, byte by byte, as a folder; and what a PC is offered by DHCP.
. "$(dirname "$0")/cli.bash"
: "${GADGET:?the program ttfbox-gadget}"
in=$WORK/kernel
made=$in/config/usb_gadget/ttfbox

expect 0 "$GADGET" --into "$in" --serial 0007 compose
said out 'serial 0007, network 10.'
# Every file with its bytes, every link with its place: nothing more, nothing less. The numbers: USB 2.0, table 9-8, and the ECN
# of interface association descriptors; Microsoft OS Descriptors 1.0, "The OS String Descriptor" and "Extended Compat ID".
(cd "$made" && find . -type f -printf '%P ' -exec sh -c 'tr "\n" ";" <"$1"' sh {} \; -printf '\n' -o -type l -printf '%P -> %l\n') |
    sed "s|$made/||" | LC_ALL=C sort >is
# The addresses as the program says them; which they may be comes below.
box=$(sed -n 's/.*addresses \([^ ]*\) (box).*/\1/p' out)
pc=$(sed -n 's/.* and \([^ ]*\) (PC).*/\1/p' out)
LC_ALL=C sort >wanted <<END
bDeviceClass 0xef;
bDeviceProtocol 0x01;
bDeviceSubClass 0x02;
bcdDevice 0x0100;
bcdUSB 0x0200;
configs/c.1/MaxPower 500;
configs/c.1/bmAttributes 0x80;
configs/c.1/ffs.ttfbox -> functions/ffs.ttfbox
configs/c.1/ncm.usb0 -> functions/ncm.usb0
configs/c.1/strings/0x409/configuration streams and network;
functions/ncm.usb0/dev_addr $box;
functions/ncm.usb0/host_addr $pc;
functions/ncm.usb0/os_desc/interface.ncm/compatible_id WINNCM;
idProduct 0x0001;
idVendor 0x1209;
os_desc/b_vendor_code 0xcd;
os_desc/c.1 -> configs/c.1
os_desc/qw_sign MSFT100;
os_desc/use 1;
strings/0x409/manufacturer ttfbox;
strings/0x409/product ttfbox capture box;
strings/0x409/serialnumber 0007;
END
diff wanted is >differs || fail "the gadget is another: $(cat differs)"

# --- addresses: of nobody else (locally administered), of one machine each, and those of the serial
[[ $box =~ ^02(:[0-9a-f]{2}){5}$ && $pc =~ ^06(:[0-9a-f]{2}){5}$ ]] || fail "no hardware addresses: $box, $pc"
cp out first
expect 0 "$GADGET" --into "$WORK/again" --serial 0007 show
cmp -s first out || fail "the same serial has other addresses"
expect 0 "$GADGET" --into "$WORK/again" --serial 0008 show
grep -q "$box" out && fail "two boxes have one address"

# --- DHCP: an address, and no router, no names
network=$(cat "$in/network/70-ttfbox-usb.network")
for line in "MACAddress=$box" DHCPServer=yes EmitRouter=no EmitDNS=no EmitNTP=no LinkLocalAddressing=ipv6; do
    grep -qx "$line" <<<"$network" || fail "the network lacks $line"
done
for line in "MACAddress=$box" MACAddressPolicy=none; do
    grep -qx "$line" "$in/network/70-ttfbox-usb.link" || fail "udev is not told: $line"
done
# A network of six addresses: the box has the first, the PC gets one of the others.
address=$(sed -n 's/^Address=\(.*\)$/\1/p' <<<"$network")
"$PYTHON" - "$address" <<'END' || fail "the box's address is $address"
import ipaddress, sys
box = ipaddress.ip_interface(sys.argv[1])
assert box.is_private and box.network.prefixlen == 29 and box.ip == box.network[1]
END

# --- what the kernel, the PC's side and udev's rule call a box is one name
grep -q 'ATTR{product}=="ttfbox capture box"' "$SOURCE/firmware/units/70-ttfbox-usb.rules" || fail "udev knows another name"
grep -q 'ATTR{idVendor}=="1209", ATTR{idProduct}=="0001"' "$SOURCE/firmware/units/70-ttfbox-usb.rules" || fail "udev knows other numbers"
grep -q '"ttfbox capture box"' "$SOURCE/firmware/usb/include/ttf/usb/identity.h" || fail "the PC's side knows another name"
grep -qE 'TTF_USB_VENDOR +0x1209' "$SOURCE/firmware/usb/include/ttf/usb/identity.h" || fail "the PC's side knows another number"

# --- bound to the controller that there is, and once; unbound; taken away
expect 1 "$GADGET" --into "$in" bind
said err 'no USB device controller'
mkdir -p "$in/udc/fe980000.usb"
expect 0 "$GADGET" --into "$in" bind
[ "$(cat "$made/UDC")" = fe980000.usb ] || fail "it is bound to $(cat "$made/UDC")"
expect 0 "$GADGET" --into "$in" bind
expect 1 "$GADGET" --into "$in" --serial 0007 compose
said err 'there is a gadget already'
[ "$(cat "$made/UDC")" = fe980000.usb ] || fail "a second compose took the first away"
# --- behind an end of the service: unbound if it is stopped, and never when it comes again
mkdir systemd
cat >systemd/systemctl <<'END'
#!/bin/sh
[ -z "${MUTE:-}" ] || exit 1
cat "$JOBS"
END
cat >systemd/systemd-notify <<'END'
#!/bin/sh
echo "$*" >>"$TOLD"
END
chmod +x systemd/*
export JOBS=$WORK/jobs TOLD=$WORK/told
ended() { # UNBOUND JOB...: whether it is unbound, where systemd has these jobs
    local unbound=$1 is=no
    shift
    printf '%s\n' "$@" >"$JOBS"
    : >"$TOLD"
    expect 0 "$GADGET" --into "$in" bind
    expect 0 env "PATH=$WORK/systemd:$PATH" NOTIFY_SOCKET=/nobody "$GADGET" --into "$in" stopped
    [ -n "$(cat "$made/UDC")" ] || is=yes
    [ "$is" = "$unbound" ] || fail "unbound: $is, with the jobs: $*"
    if [ "$unbound" = yes ]; then said told 'FDSTOREREMOVE=1 FDNAME=ep0'; else [ ! -s told ] || fail "what is kept is given back"; fi
}
ended no ''                                      # killed, or by the watchdog: it comes by itself
ended no '7 ttfbox-usbd.service restart running' # systemctl restart
ended no '7 ttfboxd.service stop running'
ended yes '7 ttfbox-usbd.service stop running' # systemctl stop, shutting down
ended yes '7 ttfbox-usbd.service restart waiting' '8 ttfbox-gadget.service restart waiting'
ended yes '8 ttfbox-gadget.service stop waiting' '7 ttfbox-usbd.service stop running'
MUTE=1 ended no '7 ttfbox-usbd.service stop running'
expect 0 "$GADGET" --into "$in" unbind
[ -z "$(cat "$made/UDC")" ] || fail "it is bound still"
expect 0 "$GADGET" --into "$in" remove
if [ -e "$made" ] || [ -n "$(ls "$in/network")" ]; then fail "something is left"; fi
expect 0 "$GADGET" --into "$in" remove

# --- what a start left halfway does not keep the next from it
mkdir -p "$made/configs/c.1"
expect 0 "$GADGET" --into "$in" --serial 0007 compose
[ -e "$made/os_desc/c.1" ] || fail "what was left halfway was kept"
expect 0 "$GADGET" --into "$in" remove

# --- what a board says of itself is no reason not to start; nor what a person wrote; without either, one of the installation's own
tree=$in/sys/firmware/devicetree/base
mkdir -p "$tree" "$in/etc/ttfbox"
expect 1 "$GADGET" --into "$in" show
said err 'there is no serial'
echo 0123456789abcdef0123456789abcdef >"$in/etc/machine-id"
expect 0 "$GADGET" --into "$in" show
grep -qE 'serial [0-9a-f]{12}, ' out || fail "no serial was made: $(cat out)"
grep -q 0123456789abcdef out && fail "the machine's id is told"
printf '0000000000000000\0' >"$tree/serial-number"
expect 0 "$GADGET" --into "$in" show
grep -qE 'serial [0-9a-f]{12}, ' out || fail "a serial that is none was taken: $(cat out)"
printf '12-ab_3 4\0' >"$tree/serial-number"
expect 0 "$GADGET" --into "$in" show
said out 'serial 12ab34, '
printf 'Box 7\r\n' >"$in/etc/ttfbox/usb-serial"
expect 0 "$GADGET" --into "$in" show
said out 'serial Box7, '

# --- of which functions: as it is told, as the board says, and both where nobody knows
expect 0 "$GADGET" --into "$WORK/streams" --serial 0007 --functions streams compose
said out 'no network'
alone=$WORK/streams/config/usb_gadget/ttfbox
grep -v -e ncm -e 'configuration streams' wanted >wanted_alone
(cd "$alone" && find . -type f -printf '%P ' -exec sh -c 'tr "\n" ";" <"$1"' sh {} \; -printf '\n' -o -type l -printf '%P -> %l\n') |
    sed "s|$alone/||" | LC_ALL=C sort | grep -v 'configuration streams;' >is_alone
diff wanted_alone is_alone >differs || fail "without a network it is another: $(cat differs)"
[ -d "$alone/functions/ffs.ttfbox" ] || fail "the streams are gone with the network"
[ ! -e "$WORK/streams/network" ] || fail "addresses are handed out on a network that is not there"
expect 0 "$GADGET" --into "$WORK/streams" remove
functions_of() { # BOARD: those of a box whose configuration names it
    mkdir -p "$WORK/of/etc/ttfbox"
    printf 'board: %s\nset: {%s}\n' "$1" "${2:-}" >"$WORK/of/etc/ttfbox/ttfboxd.yaml"
    expect 0 "$GADGET" --into "$WORK/of" --serial 0007 --ttfbox "$TTFBOX" show
}
functions_of "$SOURCE/boards/rpi4/board.yaml"
said out 'network 10.'
functions_of "$SOURCE/boards/rpi4/board.yaml" 'gadget.functions: "[streams]"'
said out 'no network'
expect 0 env "PATH=$(dirname "$TTFBOX"):$PATH" "$GADGET" --into "$WORK/of" --serial 0007 show # by hand
said out 'no network'
functions_of "$SOURCE/boards/pc-uvc/board.yaml" # it says nothing of a gadget
said out 'network 10.'
functions_of "$WORK/nowhere.yaml"
said out 'network 10.'
said err 'not known'

# --- where it is not wanted the services are left out; where nobody can say, it is, as a box is mended by its cable
wanted_of() { # CODE BOARD SET
    printf 'board: %s\nset: {%s}\n' "$2" "$3" >"$WORK/of/etc/ttfbox/ttfboxd.yaml"
    expect "$1" "$GADGET" --into "$WORK/of" --ttfbox "$TTFBOX" wanted
}
wanted_of 0 "$SOURCE/boards/rpi4/board.yaml" ''
wanted_of 1 "$SOURCE/boards/rpi4/board.yaml" 'machine.usb_role: host'
said err 'usb_role: host'
wanted_of 0 "$SOURCE/boards/sim/board.yaml" '' # it says nothing of a port
wanted_of 0 "$WORK/nowhere.yaml" ''
rm "$WORK/of/etc/ttfbox/ttfboxd.yaml"
expect 0 "$GADGET" --into "$WORK/of" --ttfbox "$TTFBOX" wanted

for wrong in network 'network streams' printer 'streams network '; do
    expect 2 "$GADGET" --into "$WORK/of" --serial 0007 --functions "$wrong" compose
    [ ! -e "$WORK/of/config" ] || fail "of '$wrong' something was made"
done

# --- a PC that has not heard that it is connected: the box's end goes down and up until it is heard, and is left alone then
expect 0 "$GADGET" --into "$WORK/watched" --serial 0007 compose
end=$WORK/watched/net/usb0
mkdir -p "$end/statistics" net
echo usb0 >"$WORK/watched/config/usb_gadget/ttfbox/functions/ncm.usb0/ifname"
cat >net/ip <<'END'
#!/bin/sh
# Down and up: connected once more; where UP_HELPS says so, the PC has heard it, and says something.
echo "$*" >>"$TOLD"
[ "$5" = up ] || exit 0
echo $(($(cat "$NET/carrier_up_count") + 1)) >"$NET/carrier_up_count"
[ "$(grep -c up "$TOLD")" -lt "$(cat "$NET/helps")" ] || echo $(($(cat "$NET/statistics/rx_packets") + 1)) >"$NET/statistics/rx_packets"
END
chmod +x net/ip
export NET=$end
at_once() { # FILE TEXT: as a file of the kernel's, which is never half there
    echo "$2" >"$1.next"
    mv "$1.next" "$1"
}
connected() { # CARRIER TIMES PACKETS HELPS: how often it was connected, which of ups it hears
    at_once "$end/statistics/rx_packets" "$3"
    at_once "$end/helps" "$4"
    at_once "$end/carrier_up_count" "$2"
    at_once "$end/carrier" "$1"
}
ups() { # N: within 20 s so many times, and no more
    for _ in $(seq 400); do
        [ "$(grep -c up "$TOLD")" -ge "$1" ] && break
        sleep 0.05
    done
    sleep 1
    [ "$(grep -c up "$TOLD")" = "$1" ] || fail "up $(grep -c up "$TOLD") times, not $1"
    [ "$(grep -c down "$TOLD")" = "$1" ] || fail "not as often down"
}
: >"$TOLD"
connected 0 0 0 9
PATH=$WORK/net:$PATH "$GADGET" --into "$WORK/watched" --every 0.02 watch 2>watching &
watcher=$!
ups 0           # nobody is connected
connected 1 1 0 2
ups 2           # heard after the second time
grep -qx 'link set dev usb0 down' "$TOLD" || fail "not as ip is called: $(cat "$TOLD")"
said watching 'nothing of it is heard: usb0 down and up'
: >"$TOLD"
at_once "$end/statistics/rx_packets" 900
ups 0           # who was heard may be silent
connected 1 9 900 99
ups 5           # plugged in anew, and its network is turned off
rm -r "$end" # the gadget is taken away
sleep 0.2
kill -0 $watcher || fail "it has ended: $(cat watching)"
kill $watcher
: >"$TOLD"
mkdir -p "$end/statistics"
connected 1 1 900 99
for n in $(seq 901 925); do # who talks by itself
    at_once "$end/statistics/rx_packets" "$n"
    sleep 0.2
done &
PATH=$WORK/net:$PATH "$GADGET" --into "$WORK/watched" --every 1 watch 2>watching &
watcher=$!
sleep 5
kill $watcher
[ ! -s "$TOLD" ] || fail "one that talks is taken down: $(cat "$TOLD")"
wait # for the talker

# --- one that said all it has to say ahead of the first look at it was heard; one that said nothing was not, whatever others said before
now_is() { # FOLDER: as the kernel has it, at once
    ln -sfn "$1" now
    mv -T now "$end"
}
rm -r "$end"
for at in away said mute; do mkdir -p "$at/statistics"; done
end=away connected 0 1 900 99
end=said connected 1 2 903 99
end=mute connected 1 3 903 99
now_is "$PWD/away"
PATH=$WORK/net:$PATH "$GADGET" --into "$WORK/watched" --every 0.02 watch 2>watching &
watcher=$!
ups 0
now_is "$PWD/said"
ups 0
echo 0 >away/carrier
echo 903 >away/statistics/rx_packets
now_is "$PWD/away"
ups 0
now_is "$PWD/mute"
ups 5
kill $watcher
# Beside one that was connected, and heard, long before.
: >"$TOLD"
now_is "$PWD/said"
PATH=$WORK/net:$PATH "$GADGET" --into "$WORK/watched" --every 0.02 watch 2>watching &
watcher=$!
ups 0
kill $watcher

# Where a watch before it was ended between down and up, it is set up.
rm said/carrier
PATH=$WORK/net:$PATH "$GADGET" --into "$WORK/watched" --every 0.02 watch 2>watching &
watcher=$!
sleep 2
kill $watcher
[ "$(cat "$TOLD")" = 'link set dev usb0 up' ] || fail "an interface that is down is left so: $(cat "$TOLD")"

# --- a serial that would be something else on the bus, or in a path
for serial in 'a b' '../x' "$(printf 'a\nb')" 'ä' 123456789012345678901234567890123; do
    expect 2 "$GADGET" --into "$in" --serial "$serial" compose
    [ ! -e "$made" ] || fail "serial '$serial' made something"
done
expect 2 "$GADGET" --into "$in" dance
expect 2 "$GADGET" --nonsense compose
expect 0 "$GADGET" --help
