#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# finish.sh ROLE: within the new system: our packages, what is on, what is off, the initramfs. /debs goes away again. ROLE is
# what the board's USB port is (machine.usb_role of its description): device, host or none.
set -eu
role=$1
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

systemctl enable ttfbox-settings.service ttfbox-lampd.service ttfboxd.service ttfbox-preview.service ttfbox-alertd.service
# What would write to the root, or wants a network.
systemctl mask systemd-machine-id-commit.service systemd-firstboot.service systemd-update-done.service \
    systemd-hwdb-update.service systemd-networkd-wait-online.service apt-daily.timer apt-daily-upgrade.timer \
    dpkg-db-backup.timer e2scrub_all.timer e2scrub_reap.service ldconfig.service
# A box that is a PC's device has the cable's network, and no other: nothing says what other interfaces would be.
if [ "$role" = device ]; then
    systemctl enable ttfbox-gadget.service ttfbox-usbd.service
else
    systemctl mask systemd-networkd.service systemd-networkd.socket
fi
# Nobody can log in: a box has no password that all know. Its console shows the journal's errors.
passwd -l root
systemctl mask getty-static.service getty@.service serial-getty@.service console-getty.service

update-initramfs -c -k all
apt-get clean
rm -rf /var/lib/apt/lists/* /var/cache/apt/*.bin /var/log/* /etc/resolv.conf
