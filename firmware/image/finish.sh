#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Within the new system: our packages, what is on, what is off, the initramfs. /debs goes away again.
set -eu
export DEBIAN_FRONTEND=noninteractive
systemd-sysusers /etc/sysusers.d/00-ttfbox-image.conf
apt-get -q install -y --no-install-recommends /debs/*.deb
rm -rf /debs

# Settings are the data partition's; the machine's id comes from it, too (initramfs).
rmdir /etc/ttfbox/boards /etc/ttfbox
ln -s /data/settings/current /etc/ttfbox
: >/etc/machine-id
rm -f /var/lib/dbus/machine-id
mkdir -p /data /boot/box /var/lib/ttfbox

systemctl enable ttfbox-settings.service ttfbox-lampd.service ttfboxd.service
# What would write to the root, or wants a network.
systemctl mask systemd-machine-id-commit.service systemd-firstboot.service systemd-update-done.service \
    systemd-hwdb-update.service systemd-networkd.service systemd-networkd.socket apt-daily.timer apt-daily-upgrade.timer \
    dpkg-db-backup.timer e2scrub_all.timer e2scrub_reap.service ldconfig.service
# Nobody can log in: a box has no password that all know. Its console shows the journal's errors.
passwd -l root
systemctl mask getty-static.service getty@.service serial-getty@.service console-getty.service

update-initramfs -c -k all
apt-get clean
rm -rf /var/lib/apt/lists/* /var/cache/apt/*.bin /var/log/* /etc/resolv.conf
