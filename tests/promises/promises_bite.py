#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Shows that promises.py bites: each wrong table must be refused, for its own reason.

usage: promises_bite.py ROOT
"""
import subprocess
import sys
import tempfile
from pathlib import Path

HEAD = "## The promises\n\n| operation | when | what holds | test |\n|---|---|---|---|\n"
GOOD = "| opening | cut | nothing is lost | `a_test_of_old`, `a_test_of_a_long_name` |\n"
MATRIX = ["creating a dataset", "an image file", "committing a slot", "a segment, or its correction", "adding a calibration",
          "an event", "a note", "a sample", "a change of plan", "sealing"]


def matrix(without=None, but=""):
    """All operations with all conditions; of the one `without` all but what `but` says."""
    table = ""
    for operation in MATRIX:
        whens = ["cut off before it returns", "it has returned", "full disk, I/O error, read-only"]
        if operation == without:
            whens = [when.replace(but, "x") for when in whens if but]
        table += "".join(f"| {operation if i == 0 else ''} | {when} | it is whole | `a_test_of_old` |\n"
                         for i, when in enumerate(whens))
    return table


WRONG = [
    ("", "no table"),
    (HEAD, "no table"),
    (HEAD + GOOD + "| opening | rot | it is found | `nobody_wrote_this` |\n", "there is no test `nobody_wrote_this`"),
    (HEAD + GOOD + "| opening | rot | it is found | by looking |\n", "a promise without a test: it is found"),
    (HEAD + GOOD + "| opening | rot | | `a_test_of_old` |\n", "only the operation may be as above"),
    (HEAD + GOOD + "| opening | rot | it is found | `never_called` |\n", "there is no test `never_called`"),
    (HEAD + GOOD + matrix("a note"), "nothing is promised of a note"),
    (HEAD + GOOD + matrix("a sample"), "nothing is promised of a sample"),
    (HEAD + GOOD + matrix("an event", "read-only"), "nothing is promised of an event and a disk that can only be read"),
    (HEAD + GOOD + matrix("sealing", "I/O error"), "nothing is promised of sealing and an I/O error"),
    (HEAD + GOOD + matrix("adding a calibration", "full disk"), "nothing is promised of adding a calibration and a full disk"),
    (HEAD + GOOD + matrix("a segment, or its correction", "it has returned"),
     "nothing is promised of a segment and a cut after it has returned"),
    (HEAD + GOOD + matrix("a change of plan", "cut off before"),
     "nothing is promised of a change of plan and a cut before it returns"),
]
SOURCE = """static void a_test_of_old(void **state) {}
static void
a_test_of_a_long_name(void **state) {}
static void never_called(void **state) {}
int main(void) { cmocka_unit_test(a_test_of_old), cmocka_unit_test(a_test_of_a_long_name); }
"""


def main():
    checker = Path(sys.argv[1]) / "tests/promises/promises.py"
    bad = 0
    with tempfile.TemporaryDirectory() as tmp:
        tests = Path(tmp) / "tests"
        tests.mkdir()
        (tests / "test.c").write_text(SOURCE)
        design = Path(tmp) / "DESIGN.md"

        def check(text):
            design.write_text(text)
            return subprocess.run([sys.executable, checker, design, tests], capture_output=True, text=True)

        run = check(HEAD + GOOD + matrix())
        if run.returncode != 0:
            print("a good table was refused\n" + run.stdout)
            bad += 1
        for text, expected in WRONG:
            run = check(text)
            if run.returncode == 0 or expected not in run.stdout:
                print(f"not found: {expected}\n{text}{run.stdout}")
                bad += 1
    print(f"{len(WRONG)} wrong tables, {bad} let through")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
