#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# services.sh FILE: within the new system: on is what the board's description names (`units:`), as FILE has it of `ttfbox board show`.
set -eu
board_says() { # KEY
    sed -n "s/^$1  *//p" "$told"
}
told=$1
units=$(board_says units)
[ -n "$units" ] || { echo "image: the board names no services: units: [...] in its board.yaml" >&2; exit 1; }
for unit in ttfbox-settings $units; do
    systemctl enable "$unit.service"
done
# The cable's network, and no other: nothing says what other interfaces would be.
case " $(board_says gadget) " in
*' network '*) ;;
*) systemctl mask systemd-networkd.service systemd-networkd.socket ;;
esac
