#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# modules.sh RIG: drivers that Debian's kernel leaves out, for the kernel of RIG/system/tree: vimc (a camera that
# libcamera finds), gpio-sim and irq_sim (GPIO lines with a hand on them), i2c-stub (a bus whose chips are registers that
# scenarios fill), pwm-pca9685 (PWM channels of a chip on it), rig-cable (dummy_hcd with the speed of a bus, and isochronous) and rig-uvc (usb_f_uvc with
# the controls of a webcam). Built out of tree from the very source package of that kernel, kept in RIG/modules, and put where the guest's modprobe finds them.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
rig=$(cd "$1" && pwd)
tree=$rig/system/tree
out=$rig/modules

kernel=$(basename "$tree"/boot/vmlinuz-*)
kernel=${kernel#vmlinuz-}
version=$(zcat "$tree/usr/share/doc/linux-image-$kernel/changelog.gz" | sed -n 1p)

# A package archive for two architectures, apart from this machine's own: the guest's and the compiler's.
apt_own() { # WORD...
    apt-get -q -o Dir::Etc::sourcelist="$out/apt/list" -o Dir::Etc::sourceparts=- -o Dir::State::lists="$out/apt/lists" \
        -o Dir::Cache="$out/apt" -o APT::Architecture=arm64 -o APT::Architectures::=arm64 \
        -o APT::Architectures::="$(dpkg --print-architecture)" -o APT::Sandbox::User= "$@"
}

fetch() { # what the modules are made from, into $out/from
    local mirror deb
    mkdir -p "$out/apt/lists/partial" "$out/apt/archives/partial" "$out/from" "$out/debs"
    # shellcheck disable=SC2016 # apt's own placeholders
    mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep -v security | sed -n 1p)
    echo "deb [arch=arm64,$(dpkg --print-architecture)] $mirror bookworm main" >"$out/apt/list"
    apt_own update
    (cd "$out/debs" && apt_own download "linux-headers-$kernel:arm64" \
        "linux-headers-${kernel%-arm64}-common" linux-source-6.1 \
        "linux-kbuild-6.1:$(dpkg --print-architecture)")
    for deb in "$out"/debs/linux-headers-*.deb "$out"/debs/linux-kbuild-*.deb; do
        dpkg-deb -x "$deb" "$out/from"
    done
    dpkg-deb --fsys-tarfile "$out"/debs/linux-source-*.deb |
        tar -xO ./usr/src/linux-source-6.1.tar.xz | xz -dc -T0 |
        tar -x -C "$out/from" --strip-components=1 linux-source-6.1/drivers/media/test-drivers/vimc \
            linux-source-6.1/drivers/i2c/i2c-stub.c linux-source-6.1/drivers/pwm/pwm-pca9685.c \
            linux-source-6.1/drivers/usb/gadget/udc/dummy_hcd.c linux-source-6.1/drivers/usb/gadget/function linux-source-6.1/drivers/gpio/gpio-sim.c linux-source-6.1/drivers/gpio/gpiolib.h \
            linux-source-6.1/kernel/irq/irq_sim.c
    # The headers name each other by the places they would be installed at.
    sed -i "s|/usr/src/|$out/from/usr/src/|; s|/usr/lib/|$out/from/usr/lib/|" \
        "$out/from/usr/src/linux-headers-$kernel/Makefile"
}

build() {
    local vimc=$out/from/drivers/media/test-drivers/vimc gpio=$out/gpio uvc=$out/uvc
    mkdir -p "$gpio" "$uvc"
    cp "$out/from/drivers/gpio/gpio-sim.c" "$out/from/drivers/gpio/gpiolib.h" "$out/from/drivers/i2c/i2c-stub.c" \
        "$out/from/drivers/pwm/pwm-pca9685.c" "$gpio/"
    # irq_sim is a part of the kernel proper and was never a module: it reaches a descriptor by a function that modules
    # may not call, and says no licence.
    {
        printf '#include <linux/module.h>\n#include <linux/irq.h>\n'
        sed 's/irq_to_desc(\([a-z_>.-]*\))/irq_data_to_desc(irq_get_irq_data(\1))/' "$out/from/kernel/irq/irq_sim.c"
        printf 'MODULE_LICENSE("GPL");\n'
    } >"$gpio/irq_sim.c"
    # dummy_hcd looks at its queues 8,000 times a second, each time with room for what a high-speed bus carries in a millisecond: that costs an
    # emulated processor most of its time, and is eight times such a bus. Here both are parameters, at first a bus's own. And it serves its queues in
    # the order of their transfers, so that what goes out waits for all that was to come in; here it gets a packet of each frame. And it fails all
    # isochronous transfers, and has no such endpoint: here its own, which are commented out, are there and served (rig_cable_iso.h).
    cp "$here/rig_cable_iso.h" "$gpio/"
    sed -e 's|^#define DUMMY_TIMER_INT_NSECS.*|static unsigned int frame_ns = 1000000, frame_bytes = 512 * 13 * 8;\
module_param(frame_ns, uint, 0644);\
module_param(frame_bytes, uint, 0644);|' -e 's|DUMMY_TIMER_INT_NSECS|frame_ns|; s|total = 512.*uframes.*;|total = frame_bytes;|
        s|if (total <= 0)|if (total <= 0 \&\& usb_urb_dir_in(urb))|; s|\tlimit = total;|\tlimit = usb_urb_dir_in(urb) ? total : max(total, 512);|
        /^static const char ep0name/,/^};/{\|^/\*$|d;\|^\*/$|d}; s|^#define is_active(dum_hcd)|#include "rig_cable_iso.h"\n&|
        s|status = -EINVAL;.*fail all xfers.*|total -= isochronous(dum, urb, ep, \&status);|
        s|ep->already_seen = ep->setup_stage = 0;|ep->already_seen = usb_pipeisoc(urb->pipe), ep->setup_stage = 0;|' \
        "$out/from/drivers/usb/gadget/udc/dummy_hcd.c" >"$gpio/rig-cable.c"
    [ "$(diff "$out/from/drivers/usb/gadget/udc/dummy_hcd.c" "$gpio/rig-cable.c" | grep -c '^>')" = 11 ]
    printf 'obj-m := gpio-sim.o irq_sim.o i2c-stub.o pwm-pca9685.o rig-cable.o\n' >"$gpio/Makefile"
    # usb_f_uvc's camera has the controls that are constants in its source: here those of a webcam. Terminal: exposure mode, priority and time, focus and
    # its mode; unit: brightness, white balance and its mode, gain, power line frequency.
    cp "$out"/from/drivers/usb/gadget/function/{*uvc*.c,*uvc*.h} "$uvc/"
    sed -i 's|cd->bmControls\[0\].*= 2;|cd->bmControls[0] = 0x2e;|; s|cd->bmControls\[2\].*= 0;|cd->bmControls[2] = 0x02;|
        s|pd->bmControls\[0\].*= 1;|pd->bmControls[0] = 0x41;|; s|pd->bmControls\[1\].*= 0;|pd->bmControls[1] = 0x16;|' "$uvc/f_uvc.c"
    [ "$(grep -c 'bmControls\[.\] = 0x' "$uvc/f_uvc.c")" = 4 ]
    printf 'obj-m := rig-uvc.o\nrig-uvc-y := f_uvc.o uvc_queue.o uvc_v4l2.o uvc_video.o uvc_configfs.o\n' >"$uvc/Makefile"
    local folder
    for folder in "$vimc" "$gpio" "$uvc"; do
        make -s -C "$out/from/usr/src/linux-headers-$kernel" ARCH=arm64 CROSS_COMPILE=aarch64-linux-gnu- \
            M="$folder" CONFIG_VIDEO_VIMC=m modules
    done
    cp "$vimc/vimc.ko" "$gpio/gpio-sim.ko" "$gpio/irq_sim.ko" "$gpio/i2c-stub.ko" "$gpio/pwm-pca9685.ko" "$gpio/rig-cable.ko" "$uvc/rig-uvc.ko" "$out/"
}

stamp="$kernel $version $(cat "$0" "$here/rig_cable_iso.h" | sha256sum | cut -c1-64)"
if [ "$(cat "$out/stamp" 2>/dev/null || true)" != "$stamp" ]; then
    echo "rig: building modules for the guest's kernel (about two minutes, of which most is fetching 150 MB)" >&2
    rm -rf "$out"
    mkdir -p "$out"
    trap 'tail -n 20 "$out/log" >&2; exit 1' ERR
    set -E
    fetch >"$out/log" 2>&1
    build >>"$out/log" 2>&1
    trap - ERR
    rm -rf "$out/from" "$out/debs" "$out/apt" "$out/gpio" "$out/uvc"
    echo "$stamp" >"$out/stamp"
fi
extra=$tree/lib/modules/$kernel/extra
if ! cmp -s "$out/stamp" "$extra/stamp"; then
    mkdir -p "$extra"
    cp "$out"/*.ko "$extra/"
    depmod -b "$tree" "$kernel"
    cp "$out/stamp" "$extra/stamp"
fi
