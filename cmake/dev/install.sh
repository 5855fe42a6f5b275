# shellcheck shell=bash
# SPDX-License-Identifier: Apache-2.0
# What a fresh Debian 12 needs, by purpose; sourced by ./dev. Mirrors are the
# machine's own: apt is used as it is configured.

ttf_build_packages="gcc g++ libc6-dev cmake ninja-build pkg-config git ca-certificates
 libtiff-dev libspng-dev libjpeg-dev liblcms2-dev libjansson-dev libyaml-dev nettle-dev
 zlib1g-dev libmicrohttpd-dev libcurl4-gnutls-dev libusb-1.0-0-dev libarchive-dev libgpiod-dev libcamera-dev libcmocka-dev python3-minimal libpython3-stdlib"
# Oracles and players that the tests hold our files against.
ttf_test_packages="curl xxd ffmpeg libraw-bin libimage-exiftool-perl libtiff-tools rt-tests man-db groff"
ttf_demo_packages="ffmpeg"
ttf_fuzz_packages="clang libclang-rt-14-dev"
ttf_coverage_packages="gcovr"
# An emulated arm64 board, a system for it, and a compiler for that.
ttf_rig_packages="qemu-system-arm qemu-utils mmdebstrap crossbuild-essential-arm64 kmod cpio make xz-utils e2fsprogs f2fs-tools python3-minimal"
# Programs for arm64 on this machine's processor.
ttf_qemu_user_packages="qemu-user-static"
# Debian packages; arm64's against the rig's system.
ttf_package_packages="dpkg-dev file lintian mmdebstrap"
# Bootable images, and machines to boot them in.
ttf_image_packages="mmdebstrap arch-test qemu-user-static fakeroot fdisk mtools dosfstools e2fsprogs dpkg-dev file"
ttf_image_test_packages="qemu-system-arm qemu-system-x86 qemu-efi-aarch64 ovmf qemu-utils"
ttf_lint_packages="clang-format clang-tidy shellcheck"

# Installs those of the named packages that are missing; says nothing if none is.
ttf_install() {
    local missing=() p
    for p in "$@"; do
        dpkg-query -W -f '${Status}' "$p" 2>/dev/null | grep -q 'ok installed' || missing+=("$p")
    done
    [ ${#missing[@]} -eq 0 ] && return 0
    echo "dev: installing ${missing[*]}" >&2
    local sudo=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || {
            echo "dev: packages are missing and neither root nor sudo is here: install them with" >&2
            echo "     apt-get install ${missing[*]}" >&2
            exit 1
        }
        sudo=(sudo)
    fi
    local log
    log=$(mktemp)
    if ! { "${sudo[@]}" apt-get -q update && "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get -q install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
        tail -n 30 "$log" >&2
        echo "dev: apt-get failed (whole log: $log)" >&2
        exit 1
    fi
    rm -f "$log"
}

# A browser and what drives it. Machines that have Node from elsewhere keep it: Debian's npm would take it away.
ttf_install_web() {
    local packages=(chromium) dir
    command -v node >/dev/null || packages+=(nodejs)
    command -v npm >/dev/null || packages+=(npm)
    ttf_install "${packages[@]}"
    dir=$PWD/tests/web
    cmp -s "$dir/package-lock.json" "$dir/node_modules/.installed" && return 0
    echo "dev: installing what drives the browser (npm)" >&2
    local log
    log=$(mktemp)
    if ! npm ci --prefix "$dir" --ignore-scripts --no-audit --no-fund >"$log" 2>&1; then
        tail -n 30 "$log" >&2
        echo "dev: npm failed (whole log: $log)" >&2
        exit 1
    fi
    rm -f "$log"
    cp "$dir/package-lock.json" "$dir/node_modules/.installed"
}

# shellcheck disable=SC2086 # the lists are meant to be split
ttf_install_build() { ttf_install $ttf_build_packages; }
# shellcheck disable=SC2086
ttf_install_test() { ttf_install $ttf_test_packages; }
# shellcheck disable=SC2086
ttf_install_demo() { ttf_install $ttf_demo_packages; }
# shellcheck disable=SC2086
ttf_install_fuzz() { ttf_install $ttf_fuzz_packages; }
# shellcheck disable=SC2086
ttf_install_coverage() { ttf_install $ttf_coverage_packages; }
# shellcheck disable=SC2086
ttf_install_rig() { ttf_install $ttf_rig_packages; }
# shellcheck disable=SC2086
ttf_install_qemu_user() { ttf_install $ttf_qemu_user_packages; }
# shellcheck disable=SC2086
ttf_install_package() { ttf_install $ttf_package_packages; }
# shellcheck disable=SC2086
ttf_install_image() { ttf_install $ttf_image_packages; }
# shellcheck disable=SC2086
ttf_install_image_test() { ttf_install $ttf_image_test_packages; }
# shellcheck disable=SC2086
ttf_install_lint() { ttf_install $ttf_lint_packages; }
