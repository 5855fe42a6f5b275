#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tells the coverage that gcovr has counted, by file and by room.

    coverage.py COVERAGE.json [--write]     --write: puts what is not reached into tests/COVERAGE.md

Why a line is not reached is told from the line and those before it: the kinds are below.
"""
import collections
import json
import re
import sys

REPORT = "tests/COVERAGE.md"
KINDS = [
    ("memory", r"ENOMEM|no memory", "an allocation that failed, where no test lets it fail"),
    ("storage", r"strerrordesc|ops->|sync|EIO|ENOSPC|cannot be (written|read|opened|closed|made)|_io_",
     "an I/O operation that failed, or a device's error, at a moment that no test chooses"),
    ("system", r"pthread_|errno|EINTR|WTERMSIG|\bgate\b|queue_init|thread",
     "a call of the system that failed: threads, locks, children, signals"),
    ("limit", r"ENAMETOOLONG|too long|_MAX\b|MAX;|n--;|EFBIG|EOVERFLOW|= 1;|most",
     "a value at its limit, a path of thousands of bytes, a text cut in a character"),
    ("clean-up", r"^\s*(free|close|goto|unlink|return (r|code|error|NULL|-1|false|-r|\(\w+\)-1);|return;|break;|\}|\w+:$"
     r"|.*_(free|close|abandon|destroy|finish|discard)\()",
     "the way out after one of these: what it hands back is what was found before it"),
    ("refusal", r"ttf_err_set|return -E|return -TTF_E|return false|complain|_wrong\(|damage\(|find\(|unsupported\(|fail\(",
     "something refused that no test brings"),
    ("name", r"default:|case |\"\?\"|\"unknown\"|_names\[", "a kind that there is not, asked for by our own code alone"),
    ("event", r"events_emit|_say\(|tell_fatal", "something that is only told: no decision hangs on it"),
    ("state", r"", "a state of the box or a form of input that no test brings"),
]
LOOK_BACK = 3  # kinds of this many first places are also told by the lines before


def kind_of(source, number):
    """By the line, else by the nearest of those before it that tells."""
    for kind, pattern, _ in KINDS[:LOOK_BACK]:
        if any(re.search(pattern, source[n - 1]) for n in range(max(1, number - 3), number + 1)):
            return kind
    return next(kind for kind, pattern, _ in KINDS[LOOK_BACK:] if re.search(pattern, source[number - 1]))


class File:
    def __init__(self, entry):
        self.path = entry["file"]
        self.room = self.path.split("/")[0]
        lines = [l for l in entry["lines"] if not l.get("gcovr/noncode")]
        branches = [b for l in lines for b in l["branches"]]
        self.missed = [l["line_number"] for l in lines if l["count"] == 0]
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


def write(files):
    kinds, others, rows = collections.Counter(), [], []
    for f in files:
        if not f.missed:
            continue
        with open(f.path, encoding="utf-8") as source:
            text = source.read().splitlines()
        here = collections.Counter()
        for number in f.missed:
            kind = kind_of(text, number)
            here[kind] += 1
            others.append("| %s | `%s` | %s |" % (f.path, text[number - 1].strip().replace("|", "\\|"), kind))
        kinds += here
        rows.append("| %s | %d | %s |" % (f.path, len(f.missed), ", ".join(
            "%s %d" % (kind, here[kind]) for kind, _, _ in KINDS if here[kind])))
    with open(REPORT, "w", encoding="utf-8") as out:
        out.write("# Lines of dataset/ and capture/ that no test reaches\n\n"
                  "Written by `./dev coverage --write`; by the way, `build-coverage/coverage.html` shows each.\n\n"
                  "| room | lines reached | | branches taken | |\n|---|---|---|---|---|\n")
        for room in sorted({f.room for f in files}):
            name, *rest = row(room, [f for f in files if f.room == room]).split()
            line, branch = " ".join(rest[:3]), " ".join(rest[5:8])
            out.write("| %s/ | %s | %s %% | %s | %s %% |\n" % (name, line, rest[3], branch, rest[8]))
        out.write("\n## Why\n\n| kind | lines | it is |\n|---|---|---|\n")
        for kind, _, meaning in KINDS:
            out.write("| %s | %d | %s |\n" % (kind, kinds[kind], meaning))
        out.write("\n## By file\n\n| file | lines | by kind |\n|---|---|---|\n%s\n" % "\n".join(rows))
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
