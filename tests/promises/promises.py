#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every row of the table of promises (dataset/DESIGN.md, "The promises") names a test that
exists and is run; and each operation that writes has its rows for every condition.

A name in backticks in the last column is a test function (defined in a source under tests/,
and handed to cmocka there) or a test of CTest.

usage: promises.py DESIGN.md TESTS-FOLDER [BUILD-FOLDER]
"""
import json
import re
import subprocess
import sys
from pathlib import Path

HEADING = "## The promises"
COLUMNS = 4  # operation, when, what holds, tests
# What is said of each operation that writes, by the words of the column "when"; of an image file nothing is acknowledged
# before its slot is.
CONDITIONS = {
    "a cut before it returns": r"cut off before",
    "a cut after it has returned": r"it has (returned|been answered)",
    "a full disk": r"full disk",
    "an I/O error": r"I/O error",
    "a disk that can only be read": r"read-only|only be read",
}
OPERATIONS = ["creating a dataset", "an image file", "committing a slot", "a segment", "adding a calibration", "an event",
              "a note", "a sample", "a change of plan", "sealing"]
WITHOUT = {("an image file", "a cut after it has returned")}


def rows(text):
    """The cells of the table's rows, with the number of their line."""
    inside = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("## "):
            inside = line.strip() == HEADING
        elif inside and line.startswith("|") and not re.fullmatch(r"[|\s:-]+", line):
            yield number, [cell.strip() for cell in line.strip().strip("|").split("|")]


def holes(table):
    """What the matrix of operations and conditions lacks; an operation is known by how its name begins."""
    said = {}
    operation = ""
    for cells in table:
        operation = cells[0] or operation
        said.setdefault(operation, []).append(cells[1])
    for wanted in OPERATIONS:
        whens = [when for name, of_it in said.items() if re.match(rf"{wanted}\b", name) for when in of_it]
        if not whens:
            yield f"nothing is promised of {wanted}"
            continue
        for condition, words in CONDITIONS.items():
            if (wanted, condition) not in WITHOUT and not any(re.search(words, when) for when in whens):
                yield f"nothing is promised of {wanted} and {condition}"


def test_functions(folder):
    """Functions of type void (void **) that their own source also hands to cmocka; a long name stands on a line of its own."""
    found = set()
    for source in folder.rglob("*.c"):
        text = source.read_text()
        for name in re.findall(r"^static void\s+(\w+)\(void \*\*", text, re.M):
            if len(re.findall(rf"\b{name}\b", text)) > 1:
                found.add(name)
    return found


def ctest_names(build):
    out = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], check=True,
                         capture_output=True, text=True).stdout
    return {test["name"] for test in json.loads(out)["tests"]}


def main():
    design = Path(sys.argv[1])
    known = test_functions(Path(sys.argv[2]))
    if len(sys.argv) > 3:
        known |= ctest_names(sys.argv[3])
    bad, count = [], 0
    table = list(rows(design.read_text()))[1:]
    for number, cells in table:
        count += 1
        if len(cells) != COLUMNS or not all(cells[1:]):
            bad.append(f"{design}:{number}: a row has {COLUMNS} cells; only the operation may be as above")
            continue
        names = re.findall(r"`([^`]+)`", cells[-1])
        if not names:
            bad.append(f"{design}:{number}: a promise without a test: {cells[2]}")
        bad += [f"{design}:{number}: there is no test `{name}`" for name in names if name not in known]
    bad += [f"{design}: {hole}" for hole in holes([cells for _, cells in table])] if count else []
    if not count:
        bad.append(f"{design}: no table under '{HEADING}'")
    print("\n".join(bad + [f"{count} promises, {len(bad)} without what keeps them"]))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
