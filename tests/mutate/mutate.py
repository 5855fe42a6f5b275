#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Removes each sync, rename, check and ordering from the store, one by one, and asks the tests.

usage: mutate.py [--list] [--all-judges] [--only NAME] [NAME...]

  --list        names the mutations and what each breaks; runs nothing
  --only NAME   only this one (may be given several times; a bare NAME says the same)
  --all-judges  does not stop at the first test program that fails

Exit: 0 all caught, 1 some survived, 2 the list, a mutant's build or the tree as it is are wrong.
README.md, beside this, says how it works and how to add a mutation.
"""
import argparse
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

import mutation_list

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
WORK = ROOT / "build-mutate"
BASELINE_SECONDS = 300  # for each judge, on the tree as it is
PATIENCE = 10  # times what the tree as it is takes, and never less than:
PATIENCE_SECONDS = 20


class BuildError(Exception):
    """A tree that does not compile: the list is wrong, or the tree itself."""


CHILDREN = set()  # running now: whoever interrupts this program ends them too


def run(command, timeout=None, **kwargs):
    """Exit status (None: did not end in time, and was ended) and everything it said."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          errors="replace", start_new_session=True, **kwargs) as child:
        CHILDREN.add(child)
        try:
            said, _ = child.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            os.killpg(child.pid, signal.SIGKILL)
            said, _ = child.communicate()
            return None, said
        finally:
            CHILDREN.discard(child)
        return child.returncode, said


def interrupted(copies):
    """A handler of signals that leaves neither a child nor a folder in memory behind."""
    def handler(number, frame):
        for child in list(CHILDREN):
            os.killpg(child.pid, signal.SIGKILL)
        for copy in copies:
            shutil.rmtree(copy.scratch, ignore_errors=True)
        os._exit(128 + number)
    return handler


def failed_test(said):
    """The first test that cmocka says failed, or the last line: whatever names it best."""
    match = re.search(r"^\[  FAILED  \] (?!\d)(\w+)", said, re.M)
    if match:
        return match[1]
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    return lines[-1][:90] if lines else "it said nothing"


class Judge:
    def __init__(self, entry):
        self.program, self.rooms = entry["program"], entry["rooms"]
        self.arguments = entry.get("arguments", [])
        self.name = Path(self.program).name
        self.seconds = 0.0  # on the tree as it is


class Copy:
    """A copy of the sources with a build folder of its own, where mutants are made."""

    def __init__(self, number, sources):
        self.root, self.sources = WORK / str(number), sources
        self.build_dir = self.root / "build"
        # Nothing here cuts real power: in memory the judges need not wait for a disk.
        base = Path("/dev/shm") if os.access("/dev/shm", os.W_OK) else WORK
        self.scratch = base / f"ttf-mutate-{os.getpid()}-{number}"

    def bring_up_to_date(self):
        """Only what differs is written, so that a build has only that to do."""
        for name in self.sources:
            target, data = self.root / name, (ROOT / name).read_bytes()
            if target.is_file() and target.read_bytes() == data:
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
            shutil.copymode(ROOT / name, target)
        known = {str(self.root / name) for name in self.sources}
        for folder, folders, files in os.walk(self.root):
            if folder == str(self.root) and "build" in folders:
                folders.remove("build")
            for name in files:
                if os.path.join(folder, name) not in known:
                    os.remove(os.path.join(folder, name))
        if not (self.build_dir / "build.ninja").is_file():
            status, said = run(["cmake", "--preset", "release"], cwd=self.root)
            if status != 0:
                raise BuildError(said)

    def build(self, *programs):
        status, said = run(["ninja", "-C", self.build_dir, "-j", "1" if len(programs) == 1 else "2", *programs])
        if status != 0:
            raise BuildError("\n".join(line for line in said.splitlines() if not line.startswith("["))[:3000])

    def ask(self, judge, timeout):
        """None: it passes; else what failed."""
        shutil.rmtree(self.scratch, ignore_errors=True)
        self.scratch.mkdir(parents=True)
        try:
            status, said = run([self.build_dir / judge.program, *judge.arguments], timeout=timeout,
                               cwd=self.scratch, env={**os.environ, "TMPDIR": str(self.scratch)})
        finally:
            shutil.rmtree(self.scratch, ignore_errors=True)
        if status == 0:
            return None
        if status is None:
            return "did not end"
        if status < 0:
            return f"died of {signal.Signals(-status).name}"
        return failed_test(said)


class Verdict:
    def __init__(self, mutation):
        self.mutation, self.caught, self.error, self.seconds = mutation, [], "", 0.0

    @property
    def word(self):
        if self.error:
            return "ERROR"
        if self.caught:
            return "caught" if not self.mutation.redundant else "NOT REDUNDANT"
        return "redundant" if self.mutation.redundant else "SURVIVED"


def judge_one(copy, mutation, judges, all_judges):
    verdict, started = Verdict(mutation), time.monotonic()
    source = copy.root / mutation.file
    original = source.read_text()
    source.write_text(mutation.apply(original))
    try:
        for judge in judges:
            if mutation.file.split("/")[0] not in judge.rooms:
                continue
            copy.build(judge.program)
            failed = copy.ask(judge, max(PATIENCE_SECONDS, PATIENCE * judge.seconds))
            if failed:
                verdict.caught.append((judge.name, failed))
                if not all_judges:
                    break
    except BuildError as error:
        verdict.error = str(error)
    finally:
        source.write_text(original)
    verdict.seconds = time.monotonic() - started
    return verdict


def prepare(copies, judges):
    """Builds the tree as it is in each copy; all judges must pass in it."""
    started = time.monotonic()
    programs = [judge.program for judge in judges]
    for copy in copies:
        copy.bring_up_to_date()
        copy.build(*programs)
    for judge in judges:
        begun = time.monotonic()
        failed = copies[0].ask(judge, BASELINE_SECONDS)
        judge.seconds = time.monotonic() - begun
        if failed:
            raise BuildError(f"{judge.name} fails on the tree as it is: {failed}")
    print(f"the tree as it is passes {len(judges)} judges ({time.monotonic() - started:.0f} s with building)",
          flush=True)


def work_through(copies, mutations, judges, all_judges):
    todo, verdicts, lock = queue.SimpleQueue(), {}, threading.Lock()
    for mutation in mutations:
        todo.put(mutation)

    def worker(copy):
        while True:
            try:
                mutation = todo.get_nowait()
            except queue.Empty:
                return
            verdict = judge_one(copy, mutation, judges, all_judges)
            with lock:
                verdicts[mutation.name] = verdict
                by = "; ".join(f"{judge}: {test}" for judge, test in verdict.caught)
                print(f"[{len(verdicts)}/{len(mutations)}] {verdict.word:9} {mutation.name} "
                      f"({verdict.seconds:.1f} s) {by}", flush=True)
                if verdict.error:
                    print(verdict.error, flush=True)

    threads = [threading.Thread(target=worker, args=(copy,), daemon=True) for copy in copies]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return [verdicts[mutation.name] for mutation in mutations]


def summary(verdicts, seconds):
    print(f"\n{'mutation':44} {'verdict':13} by")
    for verdict in verdicts:
        by = f"{verdict.caught[0][0]}: {verdict.caught[0][1]}" if verdict.caught else ""
        print(f"{verdict.mutation.name:44} {verdict.word:13} {by}")
    for verdict in verdicts:
        if verdict.word in ("SURVIVED", "redundant"):
            print(f"\n{verdict.word}: {verdict.mutation.name} ({verdict.mutation.file})\n  breaks: "
                  f"{verdict.mutation.breaks}")
        if verdict.word == "redundant":
            print(f"  kept because: {verdict.mutation.redundant}")
    words = Counter(verdict.word for verdict in verdicts)
    by = Counter(verdict.caught[0][0] for verdict in verdicts if verdict.caught)
    print(f"\n{len(verdicts)} mutations in {seconds:.0f} s: " +
          ", ".join(f"{n} {word}" for word, n in words.most_common()))
    print("caught by " + ", ".join(f"{name} {n}" for name, n in by.most_common()))
    if words["ERROR"] or words["NOT REDUNDANT"]:
        return 2
    return 1 if words["SURVIVED"] else 0


def arguments():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].removeprefix("usage: "), add_help=True)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--all-judges", action="store_true")
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("names", nargs="*")
    return parser.parse_args()


def main():
    options = arguments()
    try:
        mutations = mutation_list.load(HERE / "list")
        entries = mutation_list.judges(HERE / "judges.toml")
        wrong = mutation_list.check(mutations, ROOT) + mutation_list.unjudged(mutations, entries)
        if wrong:
            raise mutation_list.ListError("\n".join(wrong))
        names = options.names + options.only
        unknown = set(names) - {mutation.name for mutation in mutations}
        if unknown:
            raise mutation_list.ListError(f"there is no mutation {', '.join(sorted(unknown))}")
        if names:
            mutations = [mutation for mutation in mutations if mutation.name in names]
        if options.list:
            for mutation in mutations:
                print(f"{mutation.name:44} {mutation.file}\n    {mutation.breaks}")
            return 0
        judges = [Judge(entry) for entry in entries]
        rooms = {mutation.file.split("/")[0] for mutation in mutations}
        judges = [judge for judge in judges if rooms & set(judge.rooms)]
        listed = subprocess.run(["git", "ls-files", "-z", "-co", "--exclude-standard"], cwd=ROOT, check=True,
                                capture_output=True, text=True).stdout
        sources = [name for name in listed.split("\0") if name and (ROOT / name).is_file()]
        copies = [Copy(number, sources) for number in range(min(os.cpu_count() or 1, len(mutations)))]
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, interrupted(copies))
        started = time.monotonic()
        prepare(copies, judges)
        return summary(work_through(copies, mutations, judges, options.all_judges), time.monotonic() - started)
    except (mutation_list.ListError, BuildError) as error:
        print(f"mutate: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
