# SPDX-License-Identifier: Apache-2.0
"""A first boot without screen or network: the settings are taken, the card grows, a capture runs, nothing is open."""
import json
import os
import re
import subprocess
import tempfile
import time

import beside
import booted
import camera
import lamps

SLOTS = int(os.environ.get("TTFBOX_IMAGE_SLOTS", "40"))
SETTINGS = """board: qemu-virt-arm64
plan: plan.yaml
zone: Europe/Berlin
data: /var/lib/ttfbox
listen: ["127.0.0.1:8417", "unix:/run/ttfbox/http.sock", "usb0:8417"]
set: {cameras.main.format: RG10, cameras.main.width: 320, cameras.main.height: 180, cameras.main.frame_period: 40ms}
"""
PLAN = """interval: 1s
count: %d
lamps: {mode: %s, settle: 150ms}
shots: [{lamps: {left: 100%%}}]
reserve: 1MB
"""
RECORDS = "/var/lib/ttfbox/plan/records.jsonl"
LOOPBACK = ("0100007F", "00000000000000000000000001000000")  # as /proc/net has them
LISTENING = ("0A", "07")  # states of TCP and of UDP there
DHCP = "00000000:0043"  # networkd's, of the cable's network alone
NAME = "00000000:14E9"  # ttfboxd's, of that as well: the box's name (multicast DNS)
SERVICES = ("ttfboxd", "ttfbox-lampd", "ttfbox-usbd", "ttfbox-preview", "ttfbox-alertd")
RESTARTS = "systemctl show -P NRestarts %s | grep -v '^$'" % " ".join(SERVICES)
STATUS = "systemctl show -P StatusText ttfboxd"


def card(board, image, plan, programs=(), mib=1024):
    """An image on a card that is so much larger than itself, with a plan."""
    booted.copy(board, image, programs)
    subprocess.run(["truncate", "-s", "+%dM" % mib, image], check=True)
    booted.put(image, "settings/ttfbox.yaml", SETTINGS)
    booted.put(image, "settings/plan.yaml", plan)


def listens_on_the_cable(m):
    """What may, as /proc/net has it: DHCP, the page, and the box's name; nothing on a machine whose port is no device, which has no such network."""
    code, out = m.run("! [ -e /sys/class/net/usb0 ] || sed -n 's|^Address=\\(.*\\)/.*|\\1|p' /run/systemd/network/70-ttfbox-usb.network")
    assert code == 0, out
    if not out.strip():
        return ()
    address = "".join("%02X" % int(part) for part in reversed(out.strip().split(".")))
    return (DHCP, NAME, "%s:%04X" % (address, 8417))


def expect_sealed_off(m):
    """What must be so in every booted image."""
    code, out = m.run("touch /x /etc/x /usr/x; grep ' / ' /proc/mounts")
    assert out.count("Read-only file system") == 3 and " / ext4 ro," in out, out
    code, out = m.run("cat /proc/net/tcp /proc/net/tcp6 /proc/net/udp /proc/net/udp6 2>/dev/null | grep -v local_address")
    # On the cable's network its page and its name; elsewhere nothing. (A connection that was, or is, listens to nobody.)
    cable = listens_on_the_cable(m)
    beyond = [line for line in out.splitlines() if line.split()[3] in LISTENING and
              line.split()[1].split(":")[0] not in LOOPBACK and line.split()[1] not in cable]
    assert not beyond, "something listens beyond this machine: " + "\n".join(beyond)
    code, out = m.run("ls -d /var/log/journal; journalctl --header --no-pager | grep 'File path' | sort -u")
    assert "/run/log/journal/" in out and "/var/log" not in out.replace("'/var/log/journal'", ""), out
    code, out = m.run("systemctl --failed --no-legend --plain | cut -d' ' -f1; systemctl --failed --no-legend --plain | cut -d' ' -f1 | "
                      "xargs -r systemctl status --no-pager -l | tail -n 30")
    assert out.strip() == "", out
    code, out = m.run("cat /etc/machine-id; blkid -p -s UUID -o value /dev/disk/by-label/ttfbox-data | tr -d -; cat /proc/sys/kernel/random/boot_id")
    lines = out.split()
    assert lines[0] == lines[1] and len(lines[0]) == 32, out
    return lines[0]


def exposure(m):
    """Of each service at most 2.0; of the one that is root's and ends, told."""
    for unit in SERVICES + ("ttfbox-carrier", "ttfbox-gadget"):
        code, out = m.run("systemd-analyze security --no-pager %s.service | tail -n 1" % unit, 120)
        print("    " + out.strip().lstrip("→ "))
        level = re.search(r": ([0-9.]+) ", out)
        assert level and (unit == "ttfbox-gadget" or float(level.group(1)) <= 2.0), out


def expect_a_device_of_a_pc(m):
    """The other end of the cable is this machine, too: a PC's program finds the box by USB and pulls what it has."""
    code, out = m.run("ttfbox usb list", 60)
    assert code == 0 and len(out.split()) > 0, out + m.journal()
    print("    at USB: " + " ".join(out.split()))
    serial = out.split()[0]
    code, out = m.run("cat /proc/sys/kernel/hostname; grep -o '\"box_serial\": *\"[^\"]*\"' /var/lib/ttfbox/plan/dataset.json")
    assert out.split()[0] == "ttfbox-" + serial and '"%s"' % serial in out, "the box has several names: %s, %s" % (serial, out)
    code, out = m.run("ttfbox pull /tmp/pulled --usb && ttfbox verify -q /tmp/pulled/plan && rm -r /tmp/pulled", 300)
    assert code == 0, out + m.journal()
    # Its address on the cable's network, which networkd has given it.
    code, out = m.run("sed -n 's/^Address=//p' /run/systemd/network/70-ttfbox-usb.network; grep -A 1 '|--' /proc/net/fib_trie")
    lines = out.split("\n", 1)
    address = lines[0].split("/")[0]
    assert address in lines[1], out + m.journal()
    # The token by the cable, once; with it the page's interface on the cable's network, without it nothing.
    code, out = m.run("ttfbox usb token --token-file /tmp/token && ttfbox pull /tmp/pulled --box http://%s:8417 --token-file /tmp/token && "
                      "ttfbox verify -q /tmp/pulled/plan && rm -r /tmp/pulled" % address, 300)
    assert code == 0, out + m.journal()
    code, out = m.run("ttfbox usb token; ttfbox pull /tmp/pulled --box http://%s:8417; rm -rf /tmp/token /tmp/pulled" % address, 60)
    assert "has shown its token before" in out and "this needs the box's token" in out, out + m.journal()


def expect_a_restart_to_be_no_unplugging(m):
    """The cable's service restarted, and its first process killed: the PC's end keeps the number that it gave the device."""
    number = "grep -l '^ttfbox capture box' /sys/bus/usb/devices/*/product | sed 's|product$|devnum|' | xargs cat"
    code, before = m.run(number)
    assert before.strip(), before + m.journal()
    for how in ("systemctl restart ttfbox-usbd", "systemctl kill -s KILL --kill-who=main ttfbox-usbd && sleep 1"):
        code, out = m.run(how, 60)
        assert code == 0, out
        m.wait("systemctl is-active ttfbox-usbd && ttfbox pull /tmp/pulled --usb && rm -r /tmp/pulled", 60)
        code, now = m.run(number)
        assert now == before, "%s was an unplugging: %s, %s" % (how, before, now) + m.journal()


def a_first_boot_takes_the_settings_and_captures_as_seen_from_outside(board, image):
    with tempfile.TemporaryDirectory(prefix="ttfbox-rt.") as folder:
        card(board, image, PLAN % (SLOTS, "capture-only"), beside.programs(board, folder))
    since = time.time()
    with booted.Booted(image) as m:
        print("    its agent answered %.0f s after the kernel's start" % m.booted_s)
        m.wait("systemctl is-active %s ttfbox-gadget && %s | grep -q -e capturing -e done" % (" ".join(SERVICES), STATUS), 300)
        beside.begin(m, 1, SLOTS)
        exposure(m)
        code, out = m.run("df --output=size -BM /data | tail -n 1; cat /etc/ttfbox/ttfboxd.yaml; ls /boot/box; "
                          "stat -c %U:%G /var/lib/ttfbox/plan; systemctl is-system-running")
        assert 950 <= int(out.split("M")[0]) <= 1024, "the data partition has not the card's size: " + out
        assert "Europe/Berlin" in out and "ttfbox:ttfbox" in out and "ttfbox-problem" not in out, out
        m.wait("%s | grep -q done" % STATUS, SLOTS * 3 + 120)
        zero = camera.boot_at(m)
        code, out = m.run("ttfbox verify /var/lib/ttfbox/plan && cat %s" % RECORDS, 200)
        assert code == 0, out[-1500:]
        records = [json.loads(text) for text in out.splitlines() if text.startswith('{"type":"slot"')]
        assert [r["index"] for r in records] == list(range(SLOTS)), out[-1500:]
        lit = camera.lamps_as_recorded(records, m.changes(since), zero)
        late, machine_late = camera.lateness_ms(records), beside.end(m, SLOTS)
        lost = camera.tell_lost(records)
        print("    %d of %d slots captured, lamps as recorded in each; slot error p99 %.1f ms, %.1f at most; cyclictest of the same minutes %.1f, %.1f" %
              (len(late), SLOTS, late[len(late) * 99 // 100], late[-1], *machine_late))
        assert all(r.get("reason") for r in lost) and len(lost) <= 1 + SLOTS // 100 and lit >= len(late), (len(lost), lit)
        assert m.lines() == {lamps.LEFT: 0, lamps.RIGHT: 1}, m.lines()
        code, out = m.run("grep -o '\"zone\":\"[^\"]*\"' %s" % RECORDS)
        assert "Europe/Berlin" in out, out
        code, out = m.run(RESTARTS)
        assert out.split() == ["0"] * len(SERVICES), "a service did not stay up: " + out + m.journal()
        expect_a_device_of_a_pc(m)
        expect_a_restart_to_be_no_unplugging(m)
        expect_sealed_off(m)
        m.off()
    assert booted.get(image, "ttfbox-problem.txt") is None


SCENARIOS = [a_first_boot_takes_the_settings_and_captures_as_seen_from_outside]
