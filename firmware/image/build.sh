#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# build.sh BOARD: a bootable image of the box BOARD, into build-image/BOARD.img. README.md.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/../.."
here=firmware/image
board=${1:-}
conf=boards/$board/image/image.conf
if [ -z "$board" ] || [ ! -f "$conf" ]; then
    echo "image: there is no image of '$board'; there are: $(find boards -name image.conf | cut -d/ -f2 | sort | xargs)" >&2
    exit 2
fi
out=build-image
work=$out/$board
# Sectors of 512 bytes. Datasets begin where the image ends: boards with other numbers would lose them.
BOOT_START=2048 BOOT_MIB=256 DATA_START=4194304
ROOT_START=$((BOOT_START + BOOT_MIB * 2048))

base_packages="systemd systemd-sysv udev kmod busybox initramfs-tools e2fsprogs dosfstools fdisk mount util-linux
 procps login passwd tzdata gpiod v4l-utils i2c-tools"

setting() { # KEY: of the board's image
    sed -n "s/^$1=//p" "$conf"
}
arch=$(setting arch) kernel=$(setting kernel) firmware=$(setting firmware) packages=$(setting packages)

# What this machine's own apt has of Debian and of Raspberry Pi; and a file of further sources, for what the machine
# does not use itself.
sources() {
    # shellcheck disable=SC2016 # apt's own placeholders
    apt-get indextargets --format '$(ORIGIN)|deb $(REPO_URI) $(CODENAME) $(COMPONENT)' 'Created-By: Packages' |
        sed -n 's/^\(Debian\|Raspberry Pi Foundation\|Raspbian\)|//p' | sort -u
    [ -z "${TTFBOX_APT_SOURCES:-}" ] || cat "$TTFBOX_APT_SOURCES"
}

# A list of packages of this processor as apt would have it, in a folder of its own.
known() { # PACKAGE
    local apt=$work/apt
    mkdir -p "$apt"/lists/partial "$apt"/cache/archives/partial "$apt/empty"
    sources >"$apt/sources.list"
    : >"$apt/status"
    local options=(-o APT::Architecture="$arch" -o APT::Architectures="$arch" -o Dir::Etc::SourceList="$PWD/$apt/sources.list"
        -o Dir::Etc::SourceParts="$PWD/$apt/empty" -o Dir::State::Lists="$PWD/$apt/lists" -o Dir::Cache="$PWD/$apt/cache"
        -o Dir::State::status="$PWD/$apt/status" -o Acquire::Languages=none)
    apt-get -qq "${options[@]}" update >&2 || true
    [ -n "$(apt-cache "${options[@]}" show "$1" 2>/dev/null)" ]
}

foreign_programs_run() {
    [ "$arch" != "$(dpkg --print-architecture)" ] || return 0
    [ -e /proc/sys/fs/binfmt_misc/status ] || mount -t binfmt_misc none /proc/sys/fs/binfmt_misc 2>/dev/null || true
    [ -e /proc/sys/fs/binfmt_misc/qemu-aarch64 ] ||
        cat /usr/lib/binfmt.d/qemu-aarch64.conf >/proc/sys/fs/binfmt_misc/register 2>/dev/null || {
        echo "image: this machine does not run $arch programs: as root, once: systemctl restart systemd-binfmt, or" >&2
        echo "       cat /usr/lib/binfmt.d/qemu-aarch64.conf >/proc/sys/fs/binfmt_misc/register" >&2
        exit 1
    }
}

fstab() { # DISK-ID
    cat <<END
# SPDX-License-Identifier: Apache-2.0
PARTUUID=$1-02 / ext4 ro,noatime 0 1
PARTUUID=$1-01 /boot/box vfat ro,umask=0077,nofail,x-systemd.device-timeout=3min 0 2
PARTUUID=$1-03 /data ext4 errors=remount-ro,noatime,nofail,x-systemd.growfs,x-systemd.device-timeout=3min 0 2
/data/datasets /var/lib/ttfbox none bind,nofail,x-systemd.requires-mounts-for=/data 0 0
tmpfs /tmp tmpfs nosuid,nodev,size=25% 0 0
tmpfs /var/tmp tmpfs nosuid,nodev,size=25% 0 0
tmpfs /var/log tmpfs nosuid,nodev,noexec,size=16M,mode=0755 0 0
tmpfs /var/lib/systemd tmpfs nosuid,nodev,noexec,size=1M,mode=0755 0 0
END
}

# Debian's part as a tar, which takes the longest and is the same until its packages change: those of the list, or theirs.
make_base() {
    local base=$1
    echo "image: making a Debian for $arch: some minutes, once" >&2
    # The initramfs is made in the end (finish.sh), not by the kernel's own script.
    INITRD=No mmdebstrap --quiet --variant=minbase --architectures="$arch" \
        --include="$(echo "$base_packages $kernel $packages" | xargs | tr ' ' ,)" \
        --dpkgopt='path-exclude=/usr/share/man/*' --dpkgopt='path-exclude=/usr/share/locale/*' \
        --dpkgopt='path-exclude=/usr/share/doc/*' --dpkgopt='path-include=/usr/share/doc/*/copyright' \
        --dpkgopt='path-include=/usr/share/doc/ttfbox*' --aptopt='APT::Install-Recommends "false"' \
        bookworm "$base.new.tar" "$work/sources.list" >"$work/mmdebstrap.log" 2>&1 ||
        { tail -n 30 "$work/mmdebstrap.log" >&2; exit 1; }
    mv "$base.new.tar" "$base"
}

# Files for the system as a tar: root's and readable to all, whoever built it out of whose checkout, whatever the umask was. They
# bring / itself along: with other rights no service would get anywhere.
tar_of_files() { # FOLDER TAR
    tar -C "$1" --numeric-owner --owner=0 --group=0 --mode=u=rwX,go=rX -cf "$2" .
}

# The system as a tar.
make_system() { # DISK-ID
    local overlay=$work/overlay base
    rm -rf "$overlay"
    mkdir -p "$overlay/etc" "$overlay/debs"
    cp -a $here/root/. "$overlay/"
    [ ! -d "boards/$board/image/root" ] || cp -a "boards/$board/image/root/." "$overlay/"
    fstab "$1" >"$overlay/etc/fstab"
    echo ttfbox >"$overlay/etc/hostname"
    printf '127.0.0.1 localhost\n127.0.1.1 ttfbox\n' >"$overlay/etc/hosts"
    cp build-package/"$arch"/*.deb $here/finish.sh $here/services.sh "$overlay/debs/"
    tar_of_files "$overlay" "$work/overlay.tar"
    sources >"$work/sources.list"
    # A week old, it is asked for anew: updates.
    base=$out/base-$(echo "$arch $base_packages $kernel $packages $(cat "$work/sources.list")" | sha256sum | cut -c1-16).tar
    [ -n "$(find "$base" -mtime -7 2>/dev/null)" ] || make_base "$base"
    echo "image: making the system of $board" >&2
    # shellcheck disable=SC2016 # the hook's own $1
    mmdebstrap --quiet --variant=custom --architectures="$arch" --setup-hook="tar -C \"\$1\" --numeric-owner -xf $base" \
        --customize-hook="tar-in $work/overlay.tar /" --customize-hook='chroot "$1" sh /debs/finish.sh '"$board" \
        bookworm "$work/system.tar" "$work/sources.list" >"$work/mmdebstrap.log" 2>&1 ||
        { tail -n 30 "$work/mmdebstrap.log" >&2; exit 1; }
}

boot_files_efi() { # TREE FOLDER DISK-ID
    local efi suffix
    case $arch in arm64) efi=systemd-bootaa64.efi suffix=AA64 ;; amd64) efi=systemd-bootx64.efi suffix=X64 ;; esac
    mkdir -p "$2/EFI/BOOT" "$2/loader/entries"
    cp "$1/usr/lib/systemd/boot/efi/$efi" "$2/EFI/BOOT/BOOT$suffix.EFI"
    cp "$1"/boot/vmlinuz-* "$2/linux"
    cp "$1"/boot/initrd.img-* "$2/initrd.gz"
    printf 'timeout 0\ndefault ttfbox.conf\neditor no\n' >"$2/loader/loader.conf"
    printf 'title ttfbox\nlinux /linux\ninitrd /initrd.gz\noptions root=PARTUUID=%s-02 ro %s\n' "$3" \
        "$(setting cmdline)" >"$2/loader/entries/ttfbox.conf"
}

# As the packages of the Pi's own source leave it in /boot/firmware, with the board's config.txt.
boot_files_pi() { # TREE FOLDER DISK-ID
    cp -r "$1/boot/firmware/." "$2/"
    cp "$1"/boot/vmlinuz-* "$2/kernel8.img"
    cp "$1"/boot/initrd.img-* "$2/initrd.gz"
    cp "boards/$board/image/boot/config.txt" "$2/config.txt"
    printf 'root=PARTUUID=%s-02 ro rootwait %s\n' "$3" "$(setting cmdline)" >"$2/cmdline.txt"
}

# Inside fakeroot: who owns what is kept without being root.
assemble() { # DISK-ID
    local tree=$work/tree boot=$work/boot img=$work/img type=ef listen
    rm -rf "$tree" "$boot"
    mkdir -p "$tree" "$boot/settings"
    tar -C "$tree" --numeric-owner -xf "$work/system.tar"
    "boot_files_$firmware" "$tree" "$boot" "$1"
    [ "$firmware" = efi ] || type=c
    # On the boot partition once; the root has no use for them.
    rm -rf "$tree"/boot/vmlinuz-* "$tree"/boot/initrd.img-* "$tree"/boot/firmware/*
    # Without the cable's network what the daemon does by itself is right.
    grep -q '^gadget .*network' "$tree/usr/lib/ttfbox/board" && listen='' || listen=/^listen:/d
    sed -e "s/@BOARD@/$board/g" -e "$listen" $here/settings/ttfbox.yaml >"$boot/settings/ttfbox.yaml"
    sed 's/$/\r/' $here/settings/README.txt >"$boot/README.txt"
    rm -f "$img" "$work"/part.*
    truncate -s $((DATA_START * 512)) "$img"
    printf 'label: dos\nlabel-id: 0x%s\nstart=%d,size=%d,type=%s,bootable\nstart=%d,size=%d,type=83\n' "$1" \
        $BOOT_START $((BOOT_MIB * 2048)) $type $ROOT_START $((DATA_START - ROOT_START)) | sfdisk -q "$img"
    truncate -s ${BOOT_MIB}M "$work/part.boot"
    mkfs.vfat -F 32 -n TTFBOX "$work/part.boot" >/dev/null
    mcopy -s -i "$work/part.boot" "$boot"/* ::
    truncate -s $(((DATA_START - ROOT_START) * 512)) "$work/part.root"
    # Never written, so it has no journal to be replayed.
    mke2fs -q -F -t ext4 -b 4096 -O ^has_journal -L ttfbox-root -m 0 -d "$tree" "$work/part.root"
    dd if="$work/part.boot" of="$img" bs=1M seek=$((BOOT_START / 2048)) conv=notrunc,sparse status=none
    dd if="$work/part.root" of="$img" bs=1M seek=$((ROOT_START / 2048)) conv=notrunc,sparse status=none
    rm -rf "$tree" "$boot" "$work"/part.*
    mv "$img" "$out/$board.img"
}

if [ "${2:-}" = assemble ]; then # ourselves, within fakeroot
    assemble "$3"
    exit 0
fi
mkdir -p "$work"
rm -f "$out/$board.img"
for package in $kernel $packages; do # before anything is begun: never half an image
    known "$package" || { echo "image: $(setting missing | sed "s/@PACKAGE@/$package/")" >&2; exit 2; }
done
foreign_programs_run
cmake/package/package.sh "$arch" >/dev/null
id=$(od -An -N4 -tx4 /dev/urandom | tr -d ' ')
make_system "$id"
fakeroot "$0" "$board" assemble "$id"
rm -rf "$work/apt" "$work/overlay" "$work/system.tar"
echo "$out/$board.img"
