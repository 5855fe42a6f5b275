#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# suites.sh [SUITE...]: the whole project, warnings being errors, compiled in chroots of newer suites, since libraries
# change between them: trixie (libgpiod 2.2, libcamera 0.4) and bookworm-backports (2.1, 0.3). Called by ./dev suites;
# chroots are kept below build-suites. Unit tests of what differs run in them, too. trixie-arm64 is the same for
# another processor, against a tree of its libraries (tests/rig/newer.py).
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/../.."
. cmake/dev/install.sh
out=build-suites
tests='^(test_lines|test_conformance_(libcamera|v4l2)|test_libcamera_.*)$'

[ "$(id -u)" -eq 0 ] || { echo "dev: suites makes chroots: run it as root" >&2; exit 2; }
# The mirror is the one that this machine's own apt is set up with.
# shellcheck disable=SC2016 # apt's own placeholders
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep -v security | sed -n 1p)

make_chroot() { # SUITE
    local packages lines=("deb $mirror $1 main") options=() base=$1
    packages=$(echo "$ttf_build_packages" | tr -s ' \n' ',')
    if [ "${1%-backports}" != "$1" ]; then
        base=${1%-backports}
        lines=("deb $mirror $base main" "deb $mirror $1 main")
        options=("--aptopt=APT::Default-Release \"$1\"")
    fi
    local stamp
    stamp=$(echo "$packages" "${lines[@]}" | sha256sum)
    [ "$(cat "$out/$1.stamp" 2>/dev/null || true)" != "$stamp" ] || return 0
    echo "suites: making a chroot of $1 (about a minute, 700 MB)" >&2
    # What was cut off while it made one may have left its /dev and /proc there.
    ! grep -q " $PWD/$out/$1/" /proc/mounts || { echo "suites: something is mounted below $out/$1: unmount it" >&2; return 1; }
    rm -rf "${out:?}/$1"
    mmdebstrap --quiet --variant=minbase --include="$packages" "${options[@]}" "$base" "$out/$1" "${lines[@]}" \
        >"$out/$1.log" 2>&1 || { tail -n 20 "$out/$1.log" >&2; return 1; }
    echo "$stamp" >"$out/$1.stamp"
}

# The sources as git knows them, changed ones included, and no others: one that is gone here is gone there. What is
# built is kept from one time to the next; tar keeps the times of files, so that only what changed is compiled.
compile() { # SUITE
    local root=$out/$1
    mkdir -p "$root/src"
    find "$root/src" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} +
    git ls-files -z --cached --others --exclude-standard |
        while IFS= read -r -d '' file; do [ ! -f "$file" ] || printf '%s\0' "$file"; done |
        tar -c --null -T - | tar -x -C "$root/src" || return 1 # set -e is off in what || follows
    chroot "$root" sh -c "cd /src && cmake -G Ninja -S . -B build -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTTFBOX_WERROR=ON \
        -DTTFBOX_LIBCAMERA=ON >build.log 2>&1 && ninja -C build -k 0 -j $(nproc) >>build.log 2>&1" ||
        { echo "suites: $1 does not build:"; grep -E '(error|warning):|^FAILED|^CMake (Error|Warning)' "$root/src/build.log" | head -n 40; return 1; }
    # With its processes: programs find out there where they lie.
    # shellcheck disable=SC2016 # expanded in there
    unshare --mount sh -c 'mount -t proc proc "$1/proc" && exec chroot "$1" sh -c "$2"' sh "$root" "cd /src && ctest --no-tests=error --test-dir build -R '$tests' -j $(nproc) >test.log 2>&1" ||
        { echo "suites: tests fail in $1:"; tail -n 20 "$root/src/test.log"; return 1; }
    # shellcheck disable=SC2016 # expanded in there
    chroot "$root" sh -c 'for l in libgpiod libcamera; do printf "%s %s, " $l "$(pkg-config --modversion $l)"; done; gcc --version' |
        sed -n "1s/^/$1: builds without a warning, $(grep -cE 'Passed' "$root/src/test.log") test programs pass: /p"
}

[ $# -gt 0 ] || set -- trixie bookworm-backports trixie-arm64
mkdir -p "$out"
failed=0
for suite; do
    if [ "$suite" = trixie-arm64 ]; then
        (ttf_install_build && ttf_install_rig && ttf_install_qemu_user && python3 tests/rig/newer.py) || failed=1
        continue
    fi
    make_chroot "$suite" && compile "$suite" || failed=1
done
exit "$failed"
