#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# package.sh [amd64 | arm64 | all]: Debian packages into build-package/ARCH/*.deb. README.md.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/../.."
out=$PWD/build-package
rig=$PWD/build-rig/system
native=$(dpkg --print-architecture)
jobs=$(nproc)

quiet() { # COMMAND...: its output only if it fails
    local log=$out/log
    "$@" >"$log" 2>&1 || { tail -n 40 "$log" >&2; exit 1; }
}

compile() { # ARCH CMAKE-ARGUMENTS...
    local arch=$1
    shift
    mkdir -p "$out/$arch"
    # What was left out, and where a tree lies, may have changed: configured each time.
    quiet cmake -G Ninja -S . -B "$out/$arch/build" -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_INSTALL_PREFIX=/usr \
        -DTTFBOX_TESTS=OFF -DTTFBOX_PACKAGE=ON -DTTFBOX_LIBCAMERA=ON -DTTFBOX_WERROR=ON -DTTFBOX_ARCHITECTURE="$arch" "$@"
    quiet ninja -C "$out/$arch/build" -j "$jobs"
}

programs() { # COMPONENT: below the folder that is built into
    case $1 in
    tools) echo bin/ttfbox lib/ttfbox/ttfbox-full ;;
    box) echo bin/ttfboxd bin/ttfbox-lampd bin/ttfbox-usbd bin/ttfbox-preview bin/ttfbox-alertd ;;
    libcamera) echo lib/ttfbox/ttfbox-libcamera.so lib/ttfbox/ttfbox-libcamera-host ;;
    esac
}

needed() { # PROGRAM: the libraries that it names
    readelf -d "$1" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | grep -v '^ld-linux' | sort
}

# What a component's programs of the native build depend on, in Debian's words.
depends() { # COMPONENT
    local work=$out/$native/depends name args=()
    mkdir -p "$work/debian"
    printf 'Source: ttfbox\n\nPackage: ttfbox\nArchitecture: any\n' >"$work/debian/control"
    for name in $(programs "$1"); do args+=("$out/$native/build/$name"); done
    (cd "$work" && dpkg-shlibdeps -O "${args[@]}" 2>/dev/null) | sed -n 's/^shlibs:Depends=//p'
}

# Another processor's programs have the same names of libraries, or its packages are not made.
same_libraries() { # ARCH
    local name
    for name in $(programs tools) $(programs box) $(programs libcamera); do
        diff <(needed "$out/$native/build/$name") <(needed "$out/$1/build/$name") >&2 ||
            { echo "package: $name of $1 needs other libraries than that of $native" >&2; exit 1; }
    done
}

pack() { # ARCH
    rm -f "$out/$1"/*.deb
    quiet cmake "-DTTFBOX_DEPENDS_tools=$(depends tools)" "-DTTFBOX_DEPENDS_box=$(depends box)" \
        "-DTTFBOX_DEPENDS_libcamera=$(depends libcamera)" "$out/$1/build"
    (cd "$out/$1" && quiet cpack --config build/CPackConfig.cmake -B "$out/$1/cpack")
    mv "$out/$1"/cpack/*.deb "$out/$1/"
    rm -rf "$out/$1/cpack" "$out/log"
    ls "$out/$1"/*.deb
}

cross() { # arm64, against the rig's system
    bash tests/rig/tree.sh "$rig"
    bash tests/rig/links.sh "$rig/tree"
    export TTFBOX_RIG_TREE=$rig/tree PKG_CONFIG_SYSROOT_DIR=$rig/tree
    export PKG_CONFIG_LIBDIR=$rig/tree/usr/lib/aarch64-linux-gnu/pkgconfig:$rig/tree/usr/share/pkgconfig
    # Pages come from a program that this machine cannot run: the native one's are the same.
    compile arm64 -DCMAKE_TOOLCHAIN_FILE="$PWD/tests/rig/cross.cmake" -DTTFBOX_MAN_FROM="$out/$native/build/man"
}

want=${1:-$native}
case $want in
amd64 | arm64) ;;
all) want="amd64 arm64" ;;
*) echo "package: amd64, arm64 or all, not '$want'" >&2; exit 2 ;;
esac
mkdir -p "$out"
compile "$native"
for arch in $want; do
    if [ "$arch" != "$native" ]; then
        [ "$arch" = arm64 ] || { echo "package: from $native only arm64 is built for" >&2; exit 2; }
        (cross)
        same_libraries "$arch"
    fi
    pack "$arch"
done
