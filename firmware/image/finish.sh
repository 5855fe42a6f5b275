#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# finish.sh BOARD: within the new system: our packages, what is on, what is off, the initramfs. /debs goes away again.
set -eu
board=$1
export DEBIAN_FRONTEND=noninteractive
systemd-sysusers /etc/sysusers.d/00-ttfbox-image.conf
apt-get -q install -y --no-install-recommends /debs/*.deb
# What its description says, by the program that reads it: also to build.sh, which looks at it there.
ttfbox board show --board "$board" >/usr/lib/ttfbox/board
sh /debs/services.sh /usr/lib/ttfbox/board
rm -rf /debs

# Settings are the data partition's; the machine's id comes from it, too (initramfs).
rmdir /etc/ttfbox/boards /etc/ttfbox
ln -s /data/settings/current /etc/ttfbox
: >/etc/machine-id
rm -f /var/lib/dbus/machine-id
mkdir -p /data /boot/box /var/lib/ttfbox

# What would write to the root, or wants a network.
systemctl mask systemd-machine-id-commit.service systemd-firstboot.service systemd-update-done.service \
    systemd-hwdb-update.service systemd-networkd-wait-online.service apt-daily.timer apt-daily-upgrade.timer \
    dpkg-db-backup.timer e2scrub_all.timer e2scrub_reap.service ldconfig.service
# Nobody can log in: a box has no password that all know. Its console shows the journal's errors.
passwd -l root
systemctl mask getty-static.service getty@.service serial-getty@.service console-getty.service

update-initramfs -c -k all
apt-get clean
rm -rf /var/lib/apt/lists/* /var/cache/apt/*.bin /var/log/* /etc/resolv.conf
