#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# tree.sh FOLDER: what the rig's machine boots, and what is compiled against for it: FOLDER/tree (a Debian arm64
# with its -dev packages), FOLDER/kernel, FOLDER/initramfs.gz. Made anew only when the list of packages changes.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=$1

packages="base-files bash dash coreutils util-linux mount grep sed libc-bin kmod udev procps busybox-static
 linux-image-arm64 v4l-utils gpiod libc6-dev linux-libc-dev libgcc-12-dev libtiff-dev libspng-dev libjpeg-dev
 liblcms2-dev libjansson-dev libyaml-dev nettle-dev zlib1g-dev libarchive-dev libmicrohttpd-dev libcurl4-gnutls-dev libusb-1.0-0-dev libgpiod-dev
 libcmocka-dev tzdata iproute2
 libcamera-dev libcamera0.0.3 libcamera-ipa libstdc++-12-dev libgcc-s1 libstdc++6 f2fs-tools e2fsprogs i2c-tools rt-tests"
# What goes into the initramfs, so that a root can be mounted at all.
modules="virtio_pci virtio_mmio 9pnet_virtio 9p virtio_blk ext4 overlay virtio_console"

stamp=$(cat "$0" "$here"/guest/* | sha256sum | cut -c1-64)
[ "$(cat "$out/stamp" 2>/dev/null || true)" != "$stamp" ] || exit 0
rm -rf "$out"
mkdir -p "$out"

# The mirror and suite are those that this machine's own apt is set up with.
# shellcheck disable=SC2016 # apt's own placeholders
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep -v security | head -n 1)
suite=bookworm
echo "rig: making an arm64 system of $suite (about a minute, 800 MB)" >&2
mmdebstrap --quiet --variant=extract --architectures=arm64 --include="$(echo "$packages" | tr -s ' \n' ',')" \
    "$suite" "$out/tree" "deb $mirror $suite main" >"$out/mmdebstrap.log" 2>&1 ||
    { tail -n 20 "$out/mmdebstrap.log" >&2; exit 75; }
chmod 755 "$out/tree"
install -m 755 "$here/guest/init" "$out/tree/etc/rig-init"
install -m 755 "$here/guest/agent" "$out/tree/etc/rig-agent"
version=$(basename "$out"/tree/boot/vmlinuz-*)
version=${version#vmlinuz-}
depmod -b "$out/tree" "$version"
cp "$out/tree/boot/vmlinuz-$version" "$out/kernel"

initramfs=$out/initramfs
mkdir -p "$initramfs"/{bin,proc,sys,dev,mod,root,ro,rw}
cp "$out/tree/bin/busybox" "$initramfs/bin/"
: >"$initramfs/mod/order"
for module in $modules; do
    modprobe -d "$out/tree" -S "$version" --show-depends "$module" | sed -n 's/^insmod \([^ ]*\).*/\1/p' |
        while read -r path; do
            name=$(basename "$path" .xz)
            grep -qx "$name" "$initramfs/mod/order" && continue
            case $path in
            *.xz) xz -dc "$path" >"$initramfs/mod/$name" ;;
            *) cp "$path" "$initramfs/mod/$name" ;;
            esac
            echo "$name" >>"$initramfs/mod/order"
        done
done
install -m 755 "$here/guest/initramfs-init" "$initramfs/init"
(cd "$initramfs" && find . | cpio -o -H newc --quiet | gzip -1) >"$out/initramfs.gz"
rm -rf "$initramfs"
echo "$stamp" >"$out/stamp"
