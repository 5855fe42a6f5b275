#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the rig does around its scenarios, without a machine: which are run, what of them is counted, how long is waited."""
import contextlib
import io
import os
import sys
import tempfile
import threading
import time
import unittest
from unittest import mock

import gpiod2
import lamps
import newer
import rig
import soak
import waited

PLAIN = lamps.lamps_are_dark_from_the_first_and_without_a_glitch
AGAIN = [s for s in gpiod2.SCENARIOS if s.__name__.startswith(PLAIN.__name__)][0]


def outcome(wrong):
    """The rig's own, of a plain scenario and one by libgpiod 2 whose tree goes wrong like this: (exit code, what it says, what was run)."""
    ran, said = [], io.StringIO()
    with tempfile.TemporaryDirectory() as folder, mock.patch.object(rig, "RIG", folder), mock.patch.object(rig, "prepare"), \
            mock.patch.object(gpiod2, "prepare", side_effect=wrong), mock.patch.object(rig, "run", lambda s, *_: ran.append(s)), \
            mock.patch.object(sys, "argv", ["rig.py", PLAIN.__name__, AGAIN.__name__]), contextlib.redirect_stdout(said):
        return rig.main(), said.getvalue(), ran


class Scenarios(unittest.TestCase):
    def test_a_whole_name_is_one_scenario_and_a_part_is_all_that_have_it(self):
        every = [PLAIN, AGAIN]
        self.assertEqual(rig.chosen(every, [PLAIN.__name__]), [PLAIN])
        self.assertEqual(rig.chosen(every, ["glitch"]), every)
        self.assertEqual(rig.chosen(every, [PLAIN.__name__, "libgpiod_2"]), every)
        self.assertEqual(rig.chosen(every, []), every)

    def test_a_second_tree_that_cannot_be_had_skips_its_own_alone(self):
        code, said, ran = outcome(newer.NotHere("no such suite"))
        self.assertEqual((code, ran), (0, [PLAIN]))
        self.assertIn("skipped (0 s): no such suite", said)
        self.assertIn("1 passed, 0 failed, %d skipped" % (1 + len(rig.NOT_HERE)), said)

    def test_a_second_tree_that_does_not_build_fails_its_own_alone(self):
        for wrong in (SystemExit("does not build"), RuntimeError("does not build"), OSError("does not build")):
            code, said, ran = outcome(wrong)
            self.assertEqual((code, ran), (1, [PLAIN]))
            self.assertIn("does not build", said)
            self.assertIn("1 passed, 1 failed", said)

    def test_one_that_is_there_is_run(self):
        code, _, ran = outcome(None)
        self.assertEqual((code, ran), (0, [PLAIN, AGAIN]))

    def test_whoever_sets_up_is_waited_for_and_not_for_ever(self):
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(rig, "RIG", folder), mock.patch.object(rig, "LOCK_S", {None: 0.2}), \
                contextlib.redirect_stderr(io.StringIO()):
            with rig.alone(None):
                before = time.monotonic()
                with self.assertRaises(SystemExit) as ended, rig.alone(None):
                    pass
            self.assertEqual(ended.exception.code, 124)
            self.assertLess(time.monotonic() - before, 5)
            with rig.alone(None):
                pass


class Emulator:
    """A thread of this program, as the emulator's monitor has it."""

    def __init__(self, thread):
        self.thread = thread

    def ask(self, what):
        assert what == "query-cpus-fast", what
        return [{"thread-id": self.thread}]


class Waits(unittest.TestCase):
    def test_the_guests_processor_alone_is_looked_at(self):
        self.assertEqual(waited.processor_of(Emulator(7)), "/proc/7/schedstat")

    def test_a_wait_is_never_longer_than_what_lies_between(self):
        host = waited.Waited(Emulator(threading.get_native_id()))
        with tempfile.TemporaryDirectory() as folder:
            host.account = folder + "/schedstat"
            with open(host.account, "w", encoding="ascii") as f:
                f.write("0 0 0")
            with host:
                since = time.time()
                os.replace(self.waited_ns(folder, 3 * 10**9), host.account)
                self.assertLessEqual(host.between_ms(since, since + 0.1), 100.001)
                self.assertGreater(host.between_ms(since, since + 0.1), 99)

    @staticmethod
    def waited_ns(folder, ns):
        with open(folder + "/next", "w", encoding="ascii") as f:
            f.write("0 %d 0" % ns)
        return f.name

    def test_an_emulator_that_ends_is_not_waited_for(self):
        host = waited.Waited(Emulator(threading.get_native_id()))
        with host:
            host.account = "/nonexistent"
            host.thread.join(10)
            self.assertFalse(host.thread.is_alive())
            asked = threading.Thread(target=host.between_ms, args=(time.time(), time.time() + 3600), daemon=True)
            asked.start()
            asked.join(10)
            self.assertFalse(asked.is_alive())


class Slots(unittest.TestCase):
    def reach(self, counts, each_s):
        """With these counts, look after look, and so many seconds from one to the next."""
        clock, left = [0.0], list(counts)

        def captured(_):
            clock[0] += each_s
            return left.pop(0)
        with mock.patch.object(soak, "captured", captured), mock.patch.object(soak.time, "monotonic", lambda: clock[0]):
            soak.reach(mock.Mock(run=lambda *_: (0, "")), 10)
        return left

    def test_a_look_without_one_is_none_that_stands_still(self):
        self.assertEqual(self.reach([1, 1, 5, 5, 5, 10], 2), [])

    def test_half_a_minute_without_one_is(self):
        with self.assertRaises(AssertionError):
            self.reach([1] + [5] * 40, 2)


if __name__ == "__main__":
    unittest.main()
