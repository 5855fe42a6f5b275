#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What try.sh does in the fresh Debian. Each step that held is a line "try: ..."; the first that does not ends it.
set -eu
export DEBIAN_FRONTEND=noninteractive
held() { echo "try: $*"; }
wrong() { echo "WRONG: $*"; exit 1; }

nobodys() { # files that no package owns
    find / -xdev -type f ! -path '/var/lib/dpkg/*' ! -path '/var/lib/apt/*' ! -path '/var/cache/*' ! -path '/var/log/*' \
        ! -path '/debs/*' ! -path '/tmp/*' ! -path '/proc/*' ! -path '/sys/*' ! -path '/dev/*' ! -path '/run/*' \
        ! -path '/etc/*-' | sort >/tmp/all
    cat /var/lib/dpkg/info/*.list | sort -u >/tmp/owned
    # Of a merged /usr, a package may own /lib/x that is found as /usr/lib/x.
    sed -n 's#^/\(lib\|bin\|sbin\)/#/usr/\1/#p' /tmp/owned | sort -u - /tmp/owned >/tmp/owned2
    comm -23 /tmp/all /tmp/owned2
}

nobodys >/tmp/before
apt-get -q update
apt-get -q install -y --no-install-recommends /debs/*.deb
held "installed with what they depend on"

ttfbox --version
ttfboxd --version
ttfbox-lampd --version
ttfbox-usbd --version
ttfbox-preview --version
ttfbox-alertd --version
ttfbox-gadget --help >/dev/null
ttfbox usb list
man -w ttfbox ttfbox-capture ttfbox-usb ttfboxd ttfbox-lampd ttfbox-usbd ttfbox-gadget ttfbox-preview ttfbox-alertd
getent passwd ttfbox ttfbox-lampd ttfbox-usbd ttfbox-preview ttfbox-alertd
[ "$(stat -c '%U:%G %a' /run/ttfbox)" = "root:ttfbox 2775" ] || wrong "/run/ttfbox: $(stat -c '%U:%G %a' /run/ttfbox)"
held "programs, pages, users and folders are there"

printf 'board: pi\ncameras: {main: {backend: libcamera, name: none of these}}\nclock: {backend: machine}\nlock: none\n' >/tmp/pi.yaml
ttfbox board probe --board /tmp/pi.yaml >/tmp/pi.said 2>&1 || true
grep -q 'finds no camera' /tmp/pi.said || wrong "$(cat /tmp/pi.said)"
held "the module for libcamera is found, and libcamera answers"

systemd-analyze verify ttfboxd.service ttfbox-lampd.service ttfbox-gadget.service ttfbox-usbd.service ttfbox-carrier.service 2>/tmp/verify || wrong "$(cat /tmp/verify)"
if grep ttfbox /tmp/verify; then wrong "systemd has something to say"; fi
[ "$(systemctl is-enabled ttfboxd.service || true)" = disabled ] || wrong "ttfboxd is enabled by itself"
[ "$(systemctl is-enabled ttfbox-lampd.service || true)" = disabled ] || wrong "ttfbox-lampd is enabled by itself"
held "systemd takes the services, and nothing is enabled"

printf 'interval: 1min\ncount: 5\nshots: [{exposure: 20ms}]\nkeep: developed\nreserve: 1MB\n' >/tmp/tiny.yaml
mkdir -p /var/lib/ttfbox
ttfbox capture -q /tmp/tiny.yaml -b sim-small -o /var/lib/ttfbox/tiny
ttfbox verify -q /var/lib/ttfbox/tiny
sums=$(cd /var/lib/ttfbox && find . -type f | sort | xargs sha256sum)
held "a capture in the simulated box, verified"

cp /usr/share/doc/ttfbox-box/examples/ttfboxd.yaml /etc/ttfbox/ttfboxd.yaml
cp /tmp/tiny.yaml /etc/ttfbox/plan.yaml
ttfboxd --check --config /etc/ttfbox/ttfboxd.yaml
systemctl enable ttfboxd.service ttfbox-lampd.service
apt-get -q install -y --reinstall /debs/*.deb
[ "$(systemctl is-enabled ttfboxd.service)" = enabled ] || wrong "installing again has disabled it"
held "the example is a configuration; installed again, it stays enabled"

same_data() { [ "$(cd /var/lib/ttfbox && find . -type f | sort | xargs sha256sum)" = "$sums" ] || wrong "datasets were touched"; }
dpkg --remove ttfbox-libcamera ttfbox-box ttfbox
same_data
[ -e /etc/ttfbox/ttfboxd.yaml ] || wrong "removing took a configuration"
if find /etc/systemd -name 'ttfbox*' | grep .; then wrong "links of services are left"; fi
held "removed: datasets and configuration stay, no link is left"

dpkg --purge ttfbox-libcamera ttfbox-box ttfbox
same_data
# (Pages that "systemd-analyze verify" looked up lie in man's own cache.)
find / -xdev -name '*ttf*' ! -path '/proc/*' ! -path '/sys/*' ! -path '/tmp/*' ! -path '/debs/*' ! -path '/var/log/*' \
    ! -path '/var/cache/man/*' | sort >/tmp/left
printf '%s\n' /etc/ttfbox /etc/ttfbox/ttfboxd.yaml /var/lib/ttfbox >/tmp/allowed
diff /tmp/allowed /tmp/left || wrong "other files are left"
nobodys >/tmp/after
comm -13 /tmp/before /tmp/after | grep -v -e ^/var/lib/ttfbox/ -e ^/etc/ttfbox/ -e ^/var/lib/systemd/deb-systemd-helper >/tmp/rubbish || true
[ ! -s /tmp/rubbish ] || wrong "rubbish: $(cat /tmp/rubbish)"
rm -r /etc/ttfbox /var/lib/ttfbox
held "purged: what a person wrote and the datasets are all that is left"

apt-get -q install -y --no-install-recommends /debs/*.deb
dpkg --purge ttfbox-libcamera ttfbox-box ttfbox
for folder in /etc/ttfbox /run/ttfbox /var/lib/ttfbox; do
    [ ! -e "$folder" ] || wrong "$folder is left of a box that nobody used"
done
held "purged unused: nothing is left"
