#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tells the coverage that gcovr has counted, by file and by room.

    coverage.py COVERAGE.json [--write]     --write: puts what is not reached into tests/COVERAGE.md

Why a line is not reached, or a branch not taken, is told from its statement and the lines before it: the kinds are below.
"""
import collections
import json
import re
import sys

REPORT = "tests/COVERAGE.md"
KINDS = [
    ("memory", r"ENOMEM|no memory", "an allocation that failed, where no plain test lets it fail (./dev failures tries more of them)"),
    ("storage", r"strerrordesc|ops->|sync|EIO|ENOSPC|cannot be (written|read|opened|closed|made)|_io_",
     "an I/O operation that failed, or a device's error, at a moment that no test chooses"),
    ("system", r"pthread_|errno|EINTR|WTERMSIG|\bgate\b|queue_init|thread",
     "a call of the system that failed: threads, locks, children, signals"),
    ("library", r"\bTIFF[A-Z]\w+\(|tiff_client_|\bcms[A-Z]|\bjpeg_|\bj\w+_ptr|longjmp|SPNG_|spng_|posix_spawn|\bpoll\(",
     "a library's answer that no file of the tests makes it give: a tag that it hands out without a value, a setting that it refuses"),
    ("limit", r"ENAMETOOLONG|too long|_MAX\b|MAX;|n--;|EFBIG|EOVERFLOW|\bat most\b",
     "a value at its limit, a path of thousands of bytes, a text cut in a character"),
    ("clean-up", r"^\s*(free|close|goto|unlink|return (r|code|error|NULL|-1|false|-r|\(\w+\)-1);|return;|break;|\}|\w+:$"
     r"|.*_(free|close|abandon|destroy|finish|discard)\()"
     r"|\b(r|code|error) (==|<|!=) 0|!(r|code|error)\b|\((r|code|error)\)|return r \?",
     "the way out after one of these, and steps that are left out then: what it hands back is what was found before it"),
    ("refusal", r"ttf_err_|ENOTSUP|return -E|return -TTF_E|return false|complain|_wrong\(|damage\(|find\(|unsupported\(|fail\(",
     "something refused that no test brings"),
    ("event", r"events_emit|_say\(|tell_fatal", "something that is only told: no decision hangs on it"),
    ("state", r"", "a state of the box or a form of input that no test brings"),
]
# Of branches alone.
PART = ("part", "", "one part of a condition of several, which never decided it alone: bounds that the caller keeps, a text that has ended, values that exclude each other")
LOOK_BACK = 4  # kinds of this many first places are also told by the lines before


def statement(source, number):
    """The line, with those before it that its statement begins on."""
    first = number
    while first > 1 and number - first < 6 and not re.search(r"[;{}:]\s*(/\*.*\*/)?\s*$|^\s*$|\*/\s*$|^#", source[first - 2]):
        first -= 1
    return " ".join(line.strip() for line in source[first - 1:number])


def kind_of(source, number):
    """By the statement, else by the nearest of the lines before it that tells."""
    whole = statement(source, number)
    before = source[max(0, number - 4):number - 1]
    for kind, pattern, _ in KINDS[:LOOK_BACK]:
        if re.search(pattern, whole):
            return kind
    for kind, pattern, _ in KINDS[:LOOK_BACK]:
        if any(re.search(pattern, line) for line in before):
            return kind
    for text in (source[number - 1], whole):
        for kind, pattern, _ in KINDS[LOOK_BACK:-1]:
            if re.search(pattern, text):
                return kind
    return KINDS[-1][0]


def kind_of_side(source, number):
    """Of a branch: as its line's, else one part of a condition of several."""
    kind = kind_of(source, number)
    return "part" if kind == KINDS[-1][0] and re.search(r"&&|\|\||\?", statement(source, number)) else kind


class File:
    def __init__(self, entry):
        self.path = entry["file"]
        self.room = self.path.split("/")[0]
        lines = [l for l in entry["lines"] if not l.get("gcovr/noncode")]
        branches = [b for l in lines for b in l["branches"]]
        self.missed = [l["line_number"] for l in lines if l["count"] == 0]
        # one for each branch that is not taken of a line that is reached; those of the others go with their line
        self.sides = [l["line_number"] for l in lines if l["count"] > 0 for b in l["branches"] if b["count"] == 0]
        self.lines = len(lines)
        self.branches = len(branches)
        self.taken = sum(b["count"] > 0 for b in branches)


def percent(part, whole):
    return "%5.1f %%" % (100.0 * part / whole) if whole else "    - "


def row(name, files):
    lines, branches = sum(f.lines for f in files), sum(f.branches for f in files)
    reached = lines - sum(len(f.missed) for f in files)
    taken = sum(f.taken for f in files)
    return "%-32s %5d of %5d %s   %5d of %5d %s" % (
        name, reached, lines, percent(reached, lines), taken, branches, percent(taken, branches))


def by_kind(counted):
    return ", ".join("%s %d" % (kind, counted[kind]) for kind, _, _ in (*KINDS, PART) if counted[kind])


def write(files):
    kinds, sides, others, rows = collections.Counter(), collections.Counter(), [], []
    for f in files:
        if not f.missed and not f.sides:
            continue
        with open(f.path, encoding="utf-8") as source:
            text = source.read().splitlines()
        here = collections.Counter()
        for number in f.missed:
            kind = kind_of(text, number)
            here[kind] += 1
            others.append("| %s | `%s` | %s |" % (f.path, text[number - 1].strip().replace("|", "\\|"), kind))
        kinds += here
        there = collections.Counter(kind_of_side(text, number) for number in f.sides)
        sides += there
        rows.append("| %s | %d | %s | %d | %s |" % (f.path, len(f.missed), by_kind(here), len(f.sides), by_kind(there)))
    with open(REPORT, "w", encoding="utf-8") as out:
        out.write("# Lines of dataset/ and capture/ that no test reaches\n\n"
                  "Written by `./dev coverage --write`; by the way, `build-coverage/coverage.html` shows each.\n\n"
                  "| room | lines reached | | branches taken | |\n|---|---|---|---|---|\n")
        for room in sorted({f.room for f in files}):
            name, *rest = row(room, [f for f in files if f.room == room]).split()
            line, branch = " ".join(rest[:3]), " ".join(rest[5:8])
            out.write("| %s/ | %s | %s %% | %s | %s %% |\n" % (name, line, rest[3], branch, rest[8]))
        out.write("\n## Why\n\nBranches: of conditions on lines that are reached, one side never was.\n\n"
                  "| kind | lines | branches | it is |\n|---|---|---|---|\n")
        for kind, _, meaning in (*KINDS, PART):
            out.write("| %s | %d | %d | %s |\n" % (kind, kinds[kind], sides[kind], meaning))
        out.write("\n## By file\n\n| file | lines | by kind | branches | by kind |\n|---|---|---|---|---|\n%s\n" % "\n".join(rows))
        out.write("\n## Line by line\n\n| file | line | why |\n|---|---|---|\n%s\n"
                  % "\n".join(others))


def main():
    with open(sys.argv[1], encoding="utf-8") as f:
        files = sorted((File(e) for e in json.load(f)["files"]), key=lambda f: f.path)
    print("%-32s %s %29s" % ("", "lines reached", "branches taken"))
    for f in files:
        print(row(f.path, [f]))
    for room in sorted({f.room for f in files}):
        print(row(room + "/ in all", [f for f in files if f.room == room]))
    if "--write" in sys.argv[2:]:
        write(files)


if __name__ == "__main__":
    main()
