#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""newer.py: the whole project for arm64, warnings being errors, against the libraries of a newer suite (trixie: libgpiod
2.2, libcamera 0.4), and the unit tests of what differs, by qemu-user. A part of ./dev suites."""
import os
import re
import subprocess
import sys

from cross import HERE, ROOT, Cross

SUITE = "trixie"
NOT_HERE = 75  # as newer.sh has it
RIG = ROOT + "/build-rig"
ARM64 = Cross("%s/%s/tree" % (RIG, SUITE), "%s/arm64-%s" % (RIG, SUITE))
TESTS = r"^(test_lines|test_conformance_(libcamera|v4l2)|test_libcamera_.*)$"


class NotHere(Exception):
    """This machine's mirror has no such suite."""


def prepare(targets=()):
    """These targets, or all."""
    os.makedirs(RIG, exist_ok=True)
    done = subprocess.run(["bash", HERE + "/newer.sh", os.path.dirname(ARM64.tree), SUITE], check=False)
    if done.returncode == NOT_HERE:
        raise NotHere("no arm64 tree of %s can be made from this machine's mirror" % SUITE)
    if done.returncode != 0:
        raise RuntimeError("newer.sh ends with %d" % done.returncode)
    ARM64.configure()
    ARM64.compile(targets)


def version(library):
    return subprocess.run(["pkg-config", "--modversion", library], env=ARM64.environment(), stdout=subprocess.PIPE,
                          check=True).stdout.decode().strip()


def main():
    try:
        prepare()
    except NotHere as e:
        print("rig: %s" % e, file=sys.stderr)
        return NOT_HERE
    env = dict(os.environ, QEMU_LD_PREFIX=ARM64.libraries())
    ran = subprocess.run(["ctest", "--test-dir", ARM64.folder, "-R", TESTS, "--no-tests=error", "-j", str(os.cpu_count()),
                          "--output-on-failure"], env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    said = ran.stdout.decode(errors="replace")
    if ran.returncode != 0:
        print("%s-arm64: tests fail:\n%s" % (SUITE, said[-4000:]))
        return 1
    print("%s-arm64: builds without a warning, %d test programs pass by qemu-user: libgpiod %s, libcamera %s" %
          (SUITE, len(re.findall(r" Passed ", said)), version("libgpiod"), version("libcamera")))
    return 0


if __name__ == "__main__":
    sys.exit(main())
