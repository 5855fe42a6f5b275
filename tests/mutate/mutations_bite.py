#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Shows that a list that is wrong, or no longer fits its source, is refused, each for its own reason."""
import sys
import tempfile
from pathlib import Path

import mutation_list

SOURCE = "int r = 0;\nsync(file);\nrename(a, b);\nsync(folder);\nclose(a);\nclose(a);\n"
HEAD = '[[mutation]]\nname = "%s"\nfile = "%s"\nbreaks = "%s"\n'
GOOD = HEAD % ("no-rename", "a.c", "whole files") + "from = '''\nrename(a, b);\n'''\nto = ''''''\n"
WRONG = [
    ("", "holds [[mutation]] and nothing else"),
    (HEAD % ("gone", "a.c", "x") + "from = 'fsync(file);'\nto = ''\n", "occurs 0 times in a.c"),
    (HEAD % ("twice", "a.c", "x") + "from = 'close(a);'\nto = ''\n", "occurs 2 times in a.c"),
    (HEAD % ("lost", "b.c", "x") + "from = 'sync(file);'\nto = ''\n", "there is no b.c"),
    (HEAD % ("same", "a.c", "x") + "from = 'sync(file);'\nto = 'sync(file);'\n", "changes nothing"),
    (HEAD % ("back", "a.c", "x") + "edits = [{from = 'sync(file);', to = 'y;'}, {from = 'y;', to = 'sync(file);'}]\n",
     "changes nothing"),
    (HEAD % ("what", "a.c", " ") + "from = 'sync(file);'\nto = ''\n", "needs a breaks"),
    (HEAD % ("half", "a.c", "x") + "from = 'sync(file);'\n", "needs from and to"),
    (HEAD % ("both", "a.c", "x") + "from = 'a'\nto = ''\nedits = [{from = 'b', to = ''}]\n", "either from and to"),
    (HEAD % ("more", "a.c", "x") + "from = 'a'\nto = ''\nwhy = 'y'\n", "unknown keys: why"),
    (GOOD + GOOD, "is there twice"),
    (GOOD + "[x]\n", "holds [[mutation]] and nothing else"),
]


def complaints(folder, text):
    path = Path(folder) / "list"
    path.mkdir(exist_ok=True)
    (path / "1.toml").write_text(text)
    try:
        return "\n".join(mutation_list.check(mutation_list.load(path), folder))
    except mutation_list.ListError as error:
        return str(error)


def main():
    bad = 0
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "a.c").write_text(SOURCE)
        said = complaints(folder, GOOD)
        if said:
            print(f"a good list was refused: {said}")
            bad += 1
        mutations = mutation_list.load(Path(folder) / "list")
        for rooms, unjudged in ([["a.c"], 0], [["b.c"], 1]):
            if len(mutation_list.unjudged(mutations, [{"program": "x", "rooms": rooms}])) != unjudged:
                print(f"judges of {rooms} should leave {unjudged} without one")
                bad += 1
        for text, expected in WRONG:
            said = complaints(folder, text)
            if expected not in said:
                print(f"not found: {expected}\n{text}said: {said}\n")
                bad += 1
    print(f"{len(WRONG)} wrong lists, {bad} let through")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
