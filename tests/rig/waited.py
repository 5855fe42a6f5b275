# SPDX-License-Identifier: Apache-2.0
"""How long an emulator's processor stood waiting for a processor of this machine: what of a measured time is the host's, and no program's in the guest."""
import bisect
import threading
import time

EVERY_S = 0.01


def processor_of(machine):
    """The kernel's account of the emulator's thread that is the guest's processor."""
    thread = machine.ask("query-cpus-fast")[0]["thread-id"]
    return "/proc/%d/schedstat" % thread


class Waited:
    """Looks at that account until it is left."""

    def __init__(self, machine):
        self.account = processor_of(machine)
        self.at, self.ms = [], []
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
        with open(self.account, encoding="ascii") as f:
            self.ms.append(int(f.read().split()[1]) / 1e6)
        self.at.append(now)

    def look_on(self):
        try:
            while not self.ended.wait(EVERY_S):
                self.look()
        except OSError:  # the emulator has ended
            pass

    def between_ms(self, since, until):
        """From the last look before since to the first one after until; never more than lies between the two."""
        while self.at[-1] < until and self.thread.is_alive():
            time.sleep(EVERY_S)
        first = max(0, bisect.bisect_right(self.at, since) - 1)
        last = min(len(self.at) - 1, bisect.bisect_left(self.at, until))
        return max(0.0, min(self.ms[last] - self.ms[first], (until - since) * 1000))
