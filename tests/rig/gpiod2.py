# SPDX-License-Identifier: Apache-2.0
"""Lines driven through libgpiod 2.x: the scenarios of lamps, doors and buttons once more, with programs that were made
against trixie's libraries (newer.py) and run on those, in a root of their own within the guest."""
import os
import shutil

import inputs
import lamps
import newer
from machine import Machine

PROGRAMS = ["ttfbox", "ttfbox-lampd", "lampd_child", "strike", "test_lines"]
ROOM = "/run/newer"  # where they lie in the guest, in both roots
START = "#!/bin/sh\nexec chroot /newer %s/%s \"$@\"\n"
ENTER = ("mkdir -p /newer " + ROOM + " && cp /share/programs/* " + ROOM + " && mount -t 9p -o trans=virtio,version=9p2000.L,msize=262144,cache=loose,ro newer /newer && "
         "for m in proc sys dev run tmp; do mount --rbind /$m /newer/$m || exit 1; done; "
         "chroot /newer /lib/ld-linux-aarch64.so.1 --list " + ROOM + "/ttfbox-lampd")


class Newer(Machine):
    """With a second tree, and programs by their usual names that start the ones made for it."""

    def __init__(self, rig, share):
        self.tree = newer.ARM64.tree
        super().__init__(rig, share, devices=[
            "-fsdev", "local,id=n,path=%s,security_model=none,readonly=on,multidevs=remap" % self.tree,
            "-device", "virtio-9p-pci,fsdev=n,mount_tag=newer"])

    def __enter__(self):
        super().__enter__()
        code, out = self.run(ENTER)
        assert code == 0 and "libgpiod.so.3 " in out, out
        return self


def prepare(share):
    """The programs, where the guest finds them: SHARE beside those of the rig's own tree."""
    newer.prepare(PROGRAMS)
    shutil.rmtree(share, ignore_errors=True)
    os.makedirs(share + "/programs")
    for name in PROGRAMS:
        folder = "/bin/" if name.startswith("ttfbox") else "/tests/"
        shutil.copy(newer.ARM64.folder + folder + name, share + "/programs")
        with open(share + "/" + name, "w") as f:
            f.write(START % (ROOM, name))
        os.chmod(share + "/" + name, 0o755)
    return share


def lines_pass_their_tests(m):
    code, out = m.run("test_lines", 240)
    assert code == 0, out[-1500:]


def renamed(scenario):
    """A scenario's name is how it is asked for."""
    def again(m):
        scenario(m)
    again.__name__ = scenario.__name__ + "_by_libgpiod_2"
    return again


# Clients that are stopped are about leases, and no library's matter; killed, five times.
NOT_AGAIN = [lamps.programs_pass_their_tests_on_this_processor, lamps.killed_and_stopped_clients_leave_the_lamps_dark]
SCENARIOS = [renamed(s) for s in lamps.SCENARIOS + [lamps.clients_killed_five_times_leave_the_lamps_dark_in_time] + inputs.SCENARIOS if s not in NOT_AGAIN]
SCENARIOS.append(renamed(lines_pass_their_tests))
