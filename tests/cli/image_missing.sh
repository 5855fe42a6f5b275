#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# An image of a Raspberry Pi where no source has its kernel: exit 2 and what to add, before anything is made. Sources are folders
# here, so that neither a network nor an afternoon is needed; what reads them is the machine's own apt.
. "$(dirname "$0")/cli.bash"
command -v apt-cache >/dev/null || { echo "skipped: no apt here"; exit 77; }
chmod 755 "$WORK" # apt reads packages as a user of its own

# The builder in a tree of its own: what it would begin with next says so, and makes nothing.
mkdir -p tree/firmware tree/cmake/package repository stubs
cp -r "$SOURCE/firmware/image" tree/firmware/
cp -r "$SOURCE/boards" tree/
cat >tree/cmake/package/package.sh <<'END'
#!/bin/sh
echo "packages are made" >&2
exit 7
END
# This machine's apt names no source. Nothing else of it is replaced.
cat >stubs/apt-get <<'END'
#!/bin/sh
[ "$1" != indextargets ] || exit 0
exec /usr/bin/apt-get "$@"
END
# A machine of the board's own kind needs no emulator.
cat >stubs/dpkg <<'END'
#!/bin/sh
echo arm64
END
chmod +x tree/cmake/package/package.sh stubs/*

source_of() { # PACKAGE...: a repository with these
    for package in "$@"; do
        printf 'Package: %s\nVersion: 1\nArchitecture: arm64\nMaintainer: nobody\nFilename: ./%s.deb\nSize: 1\nSHA256: %064d\n\n' "$package" "$package" 0
    done >repository/Packages
    echo "deb [trusted=yes] file:$WORK/repository ./" >sources
}
image() { # CODE BOARD: a former image is there already
    mkdir -p tree/build-image
    : >"tree/build-image/$2.img"
    expect "$1" env "PATH=$WORK/stubs:$PATH" TTFBOX_APT_SOURCES="$WORK/sources" bash tree/firmware/image/build.sh "$2"
    [ ! -e "tree/build-image/$2.img" ] || fail "$2: the former image is taken for the new one"
}

for board in rpi4:linux-image-rpi-v8 rpi5:linux-image-rpi-2712 rpi-zero2w:linux-image-rpi-v8; do
    kernel=${board#*:} board=${board%:*}
    # --- no source at all; and Debian's own, which has the firmware and other kernels
    : >sources
    image 2 "$board"
    said err "the package $kernel for arm64 is in none of the sources of this machine's apt"
    said err "add Raspberry Pi's own apt source"
    said err TTFBOX_APT_SOURCES
    grep -q 'packages are made' err && fail "$board: something was begun"
    source_of raspi-firmware linux-image-arm64
    image 2 "$board"
    said err "the package $kernel for arm64 is in none"
    # --- the kernel, without what its boot partition is made of
    source_of "$kernel"
    image 2 "$board"
    said err 'the package raspi-firmware for arm64 is in none'
    # --- both: it is begun
    source_of "$kernel" raspi-firmware
    image 7 "$board"
    said err 'packages are made'
done

# --- a PC's is Debian's
: >sources
image 2 pc-uvc
said err "add Debian's own"
expect 2 bash tree/firmware/image/build.sh nothing
said err "there is no image of 'nothing'; there are: pc-uvc"
# --- and ./dev image is this builder
grep -qE '^ *exec firmware/image/build\.sh "\$@"' "$SOURCE/dev" || fail "./dev image is another builder"
