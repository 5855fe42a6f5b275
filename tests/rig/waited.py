# SPDX-License-Identifier: Apache-2.0
"""How long an emulator stood waiting for a processor of this machine: what of a measured time is the host's, and no program's in the guest."""
import bisect
import os
import threading
import time

EVERY_S = 0.01


def stolen_ms():
    """What this machine's own host, if it has one, gave to others."""
    with open("/proc/stat", encoding="ascii") as f:
        return int(f.readline().split()[8]) * 1000 / os.sysconf("SC_CLK_TCK")


def emulator_of(machine):
    """The process that `timeout` runs."""
    pid = machine.process.pid
    with open("/proc/%d/task/%d/children" % (pid, pid), encoding="ascii") as f:
        return int(f.read().split()[0])


class Waited:
    """Looks at the kernel's account of the emulator's threads until it is left."""

    def __init__(self, machine):
        self.tasks = "/proc/%d/task" % emulator_of(machine)
        self.at, self.ms = [], []
        self.of_thread = {}
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.look_on, daemon=True)

    def __enter__(self):
        self.look()
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.thread.join()

    def look(self):
        now = time.time()
        for task in os.listdir(self.tasks):
            try:
                with open("%s/%s/schedstat" % (self.tasks, task), encoding="ascii") as f:
                    self.of_thread[task] = int(f.read().split()[1]) / 1e6
            except OSError:  # a thread that has just ended; its waits were
                pass
        self.at.append(now)
        self.ms.append(sum(self.of_thread.values()) + stolen_ms())

    def look_on(self):
        while not self.ended.wait(EVERY_S):
            self.look()

    def between_ms(self, since, until):
        """Of all its threads together, from the last look before since to the first one after until."""
        while self.at[-1] < until and not self.ended.is_set():
            time.sleep(EVERY_S)
        first = max(0, bisect.bisect_right(self.at, since) - 1)
        last = min(len(self.at) - 1, bisect.bisect_left(self.at, until))
        return self.ms[last] - self.ms[first]
