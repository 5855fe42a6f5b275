# SPDX-License-Identifier: Apache-2.0
"""The drivers that the rig builds itself (modules.sh): they load, and do what scenarios need of them."""

# A device is there once udevd has told of it: libcamera looks for cameras in its records.
UDEV = ("mkdir -p /run/udev; /lib/systemd/systemd-udevd --daemon; "
        "udevadm trigger --type=devices --action=add --subsystem-match=video4linux --subsystem-match=media; "
        "udevadm settle -t 20")


def udev(m):
    code, out = m.run(UDEV)
    assert code == 0, out


def gpio_sim(m, lines, label="rig-sim"):
    """A bank of simulated lines; the folder whose sim_gpioN/{pull,value} is the hand outside."""
    bank = "/sys/kernel/config/gpio-sim/%s" % label
    code, out = m.run("modprobe gpio-sim && mkdir %s %s/bank && echo %d >%s/bank/num_lines && "
                      "echo %s >%s/bank/label && echo 1 >%s/live && "
                      "echo /sys/devices/platform/$(cat %s/dev_name)/$(cat %s/bank/chip_name)" %
                      (bank, bank, lines, bank, label, bank, bank, bank, bank))
    assert code == 0, out
    return out.strip().splitlines()[-1]


def simulated_lines_are_felt_and_seen(m):
    folder = gpio_sim(m, 4)
    for pull, level in (("pull-up", "1"), ("pull-down", "0")):
        code, out = m.run("echo %s >%s/sim_gpio2/pull && gpioget rig-sim 2" % (pull, folder))
        assert code == 0 and out.strip() == level, (pull, out)
    code, out = m.run("gpioset --mode=signal rig-sim 1=1 & sleep 0.5; cat %s/sim_gpio1/value; kill $!" % folder)
    assert out.split()[0] == "1", out
    # An edge reaches who waits for it.
    code, out = m.run("(sleep 1; echo pull-up >%s/sim_gpio2/pull) & timeout 20 gpiomon -n 1 -r rig-sim 2" % folder)
    assert code == 0 and "RISING" in out, out


def a_camera_appears_to_libcamera_programs(m):
    udev(m)
    code, out = m.run("modprobe vimc && udevadm settle -t 20 && ls /dev/media0 && v4l2-ctl --list-devices")
    assert code == 0 and "vimc" in out, out


SCENARIOS = [simulated_lines_are_felt_and_seen, a_camera_appears_to_libcamera_programs]
