# SPDX-License-Identifier: Apache-2.0
"""What the emulated machine itself makes of time: cyclictest (rt-tests) in an image, in the same minutes as its slots and at their interval."""
import os
import subprocess
import tarfile
import tempfile

import booted

PROGRAM, LIBRARY = "usr/bin/cyclictest", "usr/lib/aarch64-linux-gnu/libnuma.so.1"
LONGEST_US = 1000000
RESULT = "/tmp/cyclictest"


def programs(board, folder):
    """The program and its library for the board's arm64 image, from the sources that the image was made of."""
    made = booted.ROOT + "/build-image/%s" % board
    with tempfile.TemporaryDirectory(prefix="ttfbox-rt.") as work:
        subprocess.run(["mmdebstrap", "--quiet", "--variant=extract", "--architectures=arm64", "--include=rt-tests", "bookworm",
                        work + "/system.tar", made + "/sources.list"], check=True)
        with tarfile.open(work + "/system.tar") as tar:
            return [take(tar, "./" + name, folder) for name in (PROGRAM, LIBRARY)]


def take(tar, name, folder):
    to = "%s/%s" % (folder, os.path.basename(name))
    with tar.extractfile(name) as source, open(to, "wb") as target:  # follows a library's link
        target.write(source.read())
    return to


def begin(m, interval_s, slots):
    """In the guest, as the daemon's loop is scheduled: not in real time. It ends by itself."""
    code, out = m.run("(LD_LIBRARY_PATH=/usr/local/bin /usr/local/bin/cyclictest -q --policy=other -t1 -i %d -l %d -h %d >%s 2>&1 &)" %
                      (interval_s * 1000000, slots, LONGEST_US, RESULT))
    assert code == 0, out


def end(m, slots):
    """Milliseconds of lateness: its p99 and the longest."""
    m.wait("grep -q '^# Max Latencies' %s" % RESULT, slots * 3 + 60)
    out = m.run("awk '/^[0-9]/ && $2 > 0 {print $1 + 0, $2 + 0} /Overflows/ {print \"over\", $4}' %s; rm %s" % (RESULT, RESULT))[1]
    late_us = []
    for line in out.splitlines():
        what, times = line.split()
        late_us += [LONGEST_US if what == "over" else int(what)] * int(times)
    assert len(late_us) >= slots, out
    late_us.sort()
    return late_us[len(late_us) * 99 // 100] / 1000, late_us[-1] / 1000
