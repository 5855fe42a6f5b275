#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""udev_rules.py SOURCE GADGET: what udev makes of our rules: read as udev(7) has them, and tried on devices as the kernel shows them; by udevadm itself
where it can do that (verify: systemd 254 and later)."""
import fnmatch
import os
import re
import shutil
import subprocess
import sys
import tempfile

SOURCE, GADGET = sys.argv[1:]
UNITS = os.path.join(SOURCE, "firmware", "units")
MATCHES = {"ACTION", "SUBSYSTEM", "KERNEL", "ENV", "ATTR", "ATTRS", "DRIVER", "TAG"}
ASSIGNS = {"GROUP", "MODE", "OWNER", "TAG", "RUN", "ENV", "SYMLINK"}
PART = re.compile(r'\s*([A-Z]+)(?:\{([^}]*)\})?\s*(==|!=|\+=|:=|=)\s*"((?:[^"\\]|\\.)*)"\s*(,|$)')


def parts(line, at):
    """[(key, attribute, operator, value)] of a rule; all of the line is used."""
    found, here = [], 0
    while here < len(line):
        part = PART.match(line, here)
        assert part, f"{at}: udev would not read this from '{line[here:here + 40]}' on"
        key, attribute, operator, value, _ = part.groups()
        assert key in (MATCHES if operator in ("==", "!=") else ASSIGNS), f"{at}: {key}{operator} is nothing that udev knows here"
        assert attribute is not None or key not in ("ENV", "ATTR", "ATTRS"), f"{at}: {key} needs the name of one"
        found.append((key, attribute, operator, value))
        here = part.end()
    return found


def rules(name):
    with open(os.path.join(UNITS, name), encoding="ascii") as file:
        text = file.read().replace("\\\n", "")
    lines = [(i + 1, line.strip()) for i, line in enumerate(text.split("\n"))]
    return [parts(line, f"{name}:{i}") for i, line in lines if line and not line.startswith("#")]


def outcome(all_rules, device):
    """What is assigned to a device."""
    got = []
    for rule in all_rules:
        for key, attribute, operator, value in rule:
            if operator in ("==", "!="):
                has = device.get((key, attribute) if attribute else key)
                same = has is not None and any(fnmatch.fnmatchcase(has, one) for one in value.split("|"))
                if same != (operator == "=="):
                    break
        else:
            got += [(key, operator, value) for key, _, operator, value in rule if operator not in ("==", "!=")]
    return got


def usb(**other):
    """A device as the kernel shows it, with what the gadget says it is."""
    device = {"ACTION": "add", "SUBSYSTEM": "usb", ("ENV", "DEVTYPE"): "usb_device", "KERNEL": "1-1", ("ATTR", "idVendor"): said["idVendor"],
              ("ATTR", "idProduct"): said["idProduct"], ("ATTR", "product"): said["product"], ("ATTR", "serial"): "0007"}
    for key, value in other.items():
        name = next((k for k in device if k == key or k[-1] == key), ("ATTR", key))
        device[name] = value
    return device


def gadget_says():
    """sysfs shows four digits of a number, without 0x."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["sh", GADGET, "--into", folder, "--serial", "0007", "compose"], check=True, stdout=subprocess.DEVNULL)
        made = os.path.join(folder, "config", "usb_gadget", "ttfbox")
        read = lambda name: open(os.path.join(made, name), encoding="ascii").read().strip()
        return {"idVendor": "%04x" % int(read("idVendor"), 16), "idProduct": "%04x" % int(read("idProduct"), 16),
                "product": read("strings/0x409/product")}


said = gadget_says()
of_pc = rules("70-ttfbox-usb.rules")
UACCESS = [("TAG", "+=", "uaccess")]
assert outcome(of_pc, usb()) == UACCESS, "whoever sits at a PC may not use a box"
assert outcome(of_pc, usb(ACTION="bind")) == UACCESS and outcome(of_pc, usb(ACTION="change")) == UACCESS
for why, device in (("another's that shares the numbers", usb(product="somebody's keyboard")), ("one without a name", {k: v for k, v in usb().items() if k != ("ATTR", "product")}),
                    ("another product", usb(idProduct="0002")), ("another vendor", usb(idVendor="1d6b")), ("an interface of a box", usb(DEVTYPE="usb_interface")),
                    ("one that is gone", usb(ACTION="remove")), ("something else", usb(SUBSYSTEM="block"))):
    assert outcome(of_pc, device) == [], f"{why} may be used by whoever sits there"
# What gives the tag its effect is 73-seat-late.rules, and rules are read in the order of their names.
assert "70-ttfbox-usb.rules" < "73-seat-late.rules"

of_box = rules("70-ttfbox.rules")
for device, wanted in (({"SUBSYSTEM": "gpio", "KERNEL": "gpiochip0", "ACTION": "add"}, [("GROUP", "=", "gpio"), ("MODE", "=", "0660")]),
                       ({"SUBSYSTEM": "watchdog", "KERNEL": "watchdog0", "ACTION": "add"}, [("GROUP", "=", "ttfbox"), ("MODE", "=", "0660")]),
                       ({"SUBSYSTEM": "misc", "KERNEL": "watchdog", "ACTION": "add"}, [("GROUP", "=", "ttfbox"), ("MODE", "=", "0660")]),
                       ({"SUBSYSTEM": "dma_heap", "KERNEL": "linux,cma", "ACTION": "add"}, [("GROUP", "=", "video"), ("MODE", "=", "0660")]),
                       ({"SUBSYSTEM": "tty", "KERNEL": "ttyS0", "ACTION": "add"}, [])):
    assert outcome(of_box, device) == wanted, (device, outcome(of_box, device))
pwm = outcome(of_box, {"SUBSYSTEM": "pwm", "KERNEL": "pwmchip0", "ACTION": "change"})
assert len(pwm) == 1 and pwm[0][:2] == ("RUN", "+="), pwm
assert outcome(of_box, {"SUBSYSTEM": "pwm", "KERNEL": "pwmchip0", "ACTION": "remove"}) == []

udevadm = shutil.which("udevadm")
can = udevadm and subprocess.run([udevadm, "verify", "--help"], capture_output=True, check=False).returncode == 0
if can:
    subprocess.run([udevadm, "verify", *(os.path.join(UNITS, name) for name in ("70-ttfbox-usb.rules", "70-ttfbox.rules"))], check=True)
print("rules read and tried on devices; " + ("udevadm verify has nothing to say" if can else
      "not by udevadm: " + ("this one has no 'verify' (systemd 254)" if udevadm else "it is not installed")))
