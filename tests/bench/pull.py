#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`ttfbox pull` beside curl fetching the same files from the same `ttfbox serve` over TCP loopback, in turns.

usage: pull.py TTFBOX NO_HASH [--slots N] [--bytes N] [--rounds N] [--on FOLDER]

curl writes the bytes and nothing else: it knows the files' names beforehand, checks nothing, syncs nothing. It goes once plainly and once
with --parallel, over connections that it keeps; the faster counts. `pull` hashes, names each file when it is right, and syncs. Without
hashing: the same program with NO_HASH loaded before it, which leaves the hash function out, of a dataset that records just
that (but for its seal, which is not put in place then). On a disk and in memory (/dev/shm), since what a sync costs is the disk's. What came
is emptied, and deleted at the end alone: ext4 without a journal passes over the places of files that were deleted a moment ago one by one,
and whoever made files next paid for it, not whoever was measured.
"""
import argparse
import hashlib
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import zlib

PLAN = """interval: 2min
count: 2
lamps: {mode: continuous}
shots:
  - {stream: main, channel: white, lamps: {left: 100%, right: 100%}, exposure: 20ms}
keep: developed
mains: 50Hz
"""


def line(record):
    record.pop("crc", None)
    body = json.dumps(record, separators=(",", ":"))[:-1]
    return '%s,"crc":"%08x"}\n' % (body, zlib.crc32(body.encode()))


class Data:
    """Datasets 'hashed' and 'unhashed' of the same frames: a captured one's records over and over, with frames of random bytes."""

    def __init__(self, ttfbox, folder, slots, size):
        self.folder, self.slots, self.size = folder, slots, size
        plan = os.path.join(folder, "plan.yaml")
        with open(plan, "w", encoding="ascii") as file:
            file.write(PLAN)
        small = os.path.join(folder, "small")
        subprocess.run([ttfbox, "capture", plan, "--board", "sim-small", "-o", small], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        self.data = os.path.join(folder, "data")
        digests = self.frames(os.path.join(self.data, "hashed"))
        self.describe(small, "hashed", digests, lambda b: hashlib.sha256(b).hexdigest())
        os.makedirs(os.path.join(self.data, "unhashed", "frames", "main"))
        for i in range(slots):
            os.link(os.path.join(self.data, "hashed", self.path(i)), os.path.join(self.data, "unhashed", self.path(i)))
        nothing = hashlib.sha256(b"").hexdigest()
        self.describe(small, "unhashed", [nothing] * slots, lambda b: nothing)

    def path(self, i):
        return "frames/main/%06d.tif" % i

    def frames(self, folder):
        os.makedirs(os.path.join(folder, "frames", "main"))
        noise, digests = bytearray(os.urandom(self.size)), []
        for i in range(self.slots):
            noise[:8] = i.to_bytes(8, "little")
            with open(os.path.join(folder, self.path(i)), "wb") as file:
                file.write(noise)
            digests.append(hashlib.sha256(noise).hexdigest())
        return digests

    def describe(self, small, name, digests, sha256):
        """The records of a captured dataset, of so many slots, and its seal."""
        folder = os.path.join(self.data, name)
        shutil.copy(os.path.join(small, "dataset.json"), folder)
        with open(os.path.join(small, "records.jsonl"), encoding="utf-8") as file:
            records = [json.loads(text) for text in file]
        for record in records:
            for entry in record.get("files", []):
                os.makedirs(os.path.dirname(os.path.join(folder, entry["path"])), exist_ok=True)
                shutil.copy(os.path.join(small, entry["path"]), os.path.join(folder, entry["path"]))
                with open(os.path.join(small, entry["path"]), "rb") as file:
                    entry["sha256"] = sha256(file.read())
        head = [r for r in records if r["type"] not in ("slot", "end")]
        end = next(r for r in records if r["type"] == "end")
        end["seq"], end["slots"], end["captured"] = len(head) + self.slots, self.slots, self.slots
        slot = next(r for r in records if r["type"] == "slot")
        interval = next(r["interval_ns"] for r in head if r["type"] == "segment")
        due, middle, entry = slot["due_ns"], slot["middle_ns"], slot["images"][0]["files"][0]
        entry["bytes"] = self.size
        listed = {}
        with open(os.path.join(folder, "records.jsonl"), "w", encoding="utf-8") as out:
            for seq, record in enumerate(head):
                record["seq"] = seq
                out.write(line(record))
            for i in range(self.slots):
                slot["seq"], slot["index"] = len(head) + i, i
                slot["due_ns"], slot["middle_ns"] = due + i * interval, middle + i * interval
                entry["path"], entry["sha256"] = self.path(i), digests[i]
                listed[self.path(i)] = digests[i]
                out.write(line(slot))
            out.write(line(end))
        for base, _, names in os.walk(folder):
            for path in (os.path.relpath(os.path.join(base, name), folder) for name in names):
                if path not in listed:
                    with open(os.path.join(folder, path), "rb") as file:
                        listed[path] = sha256(file.read())
        with open(os.path.join(folder, "SHA256SUMS"), "w", encoding="ascii") as sums:
            sums.writelines(f"{listed[path]}  {path}\n" for path in sorted(listed))


class Run:
    """The two programs, each into a folder that is new each time."""

    def __init__(self, ttfbox, no_hash, data, url, on):
        self.ttfbox, self.no_hash, self.data, self.url = ttfbox, no_hash, data, url
        self.dest, self.emptied = os.path.join(on, "dest"), 0
        self.list = os.path.join(data.folder, "list-" + os.path.basename(on))
        with open(self.list, "w", encoding="ascii") as file:
            for i in range(data.slots):
                file.write(f'url="{url}/api/v1/datasets/hashed/files/{data.path(i)}"\noutput="{self.dest}/{data.path(i)}"\n')

    def empty(self):
        for base, _, names in os.walk(self.dest):
            for name in names:
                os.truncate(os.path.join(base, name), 0)
        if os.path.isdir(self.dest):
            self.emptied += 1
            os.rename(self.dest, f"{self.dest}-{self.emptied}")

    def timed(self, command, environment=None):
        self.empty()
        os.makedirs(os.path.join(self.dest, "frames", "main"))
        os.sync()  # what was written before is not written now
        begun = time.monotonic()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=dict(os.environ, **(environment or {})))
        return time.monotonic() - begun

    def check(self, folder):
        sizes = [os.path.getsize(os.path.join(folder, self.data.path(i))) for i in range(self.data.slots)]
        if sizes != [self.data.size] * self.data.slots:
            sys.exit("bench pull: not all has come")

    def pull(self):
        took = self.timed([self.ttfbox, "pull", self.dest, "--box", self.url, "--only", "hashed", "-q"])
        self.check(os.path.join(self.dest, "hashed"))
        return took

    def pull_unhashed(self):
        took = self.timed([self.ttfbox, "pull", self.dest, "--box", self.url, "--only", "unhashed", "-q"], {"LD_PRELOAD": self.no_hash})
        self.check(os.path.join(self.dest, "unhashed"))
        return took

    def curl(self):
        took = self.timed(["curl", "-sS", "-f", "-K", self.list])
        self.check(self.dest)
        return took

    def curl_parallel(self):
        took = self.timed(["curl", "-sS", "-f", "--parallel", "--parallel-max", "4", "-K", self.list])
        self.check(self.dest)
        return took


def compare(run, rounds, what):
    took = {name: [] for name in ("pull", "pull_unhashed", "curl", "curl_parallel")}
    ratios = []
    for i in range(rounds):
        order = list(took)
        for name in order if i % 2 == 0 else reversed(order):
            took[name].append(getattr(run, name)())
        ratios.append(min(took["curl"][-1], took["curl_parallel"][-1]) / took["pull"][-1])
        print(f"  {what}, round {i + 1}: " + ", ".join(f"{name.replace('_', ' ')} {took[name][-1]:.2f} s" for name in took)
              + f"; pull is {ratios[-1]:.2f} x as fast as the faster curl", flush=True)
    m = {name: statistics.median(values) for name, values in took.items()}
    megabytes = run.data.slots * run.data.size / 1e6
    best = min(m["curl"], m["curl_parallel"])
    print(f"{what}: pull {megabytes / m['pull']:.0f} MB/s, {run.data.slots / m['pull']:.0f} files/s; unhashed {megabytes / m['pull_unhashed']:.0f} "
          f"MB/s; curl {megabytes / m['curl']:.0f}, parallel {megabytes / m['curl_parallel']:.0f} MB/s")
    print(f"{what}: pull is {statistics.median(ratios):.2f} x as fast as curl (median of {rounds} pairs, {min(ratios):.2f} to "
          f"{max(ratios):.2f}), {best / m['pull_unhashed']:.2f} x without hashing", flush=True)
    run.empty()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ttfbox")
    parser.add_argument("no_hash")
    parser.add_argument("--slots", type=int, default=10000)
    parser.add_argument("--bytes", type=int, default=32768)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--on", action="append", help="a folder to pull to (default: one for temporary files, and /dev/shm)")
    args = parser.parse_args()
    ttfbox, no_hash = os.path.abspath(args.ttfbox), os.path.abspath(args.no_hash)
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
        data = Data(ttfbox, folder, args.slots, args.bytes)
        print(f"{args.slots} slots of {args.bytes} bytes", flush=True)
        server = subprocess.Popen([ttfbox, "serve", data.data, "--listen", "127.0.0.1:0", "--json"], stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, text=True)
        try:
            url = "http://" + json.loads(server.stdout.readline())["listening"]
            for on in args.on or [folder] + [f for f in ("/dev/shm",) if os.path.isdir(f)]:
                with tempfile.TemporaryDirectory(dir=on) as scratch:
                    compare(Run(ttfbox, no_hash, data, url, scratch), args.rounds, "in memory" if on == "/dev/shm" else "on disk")
        finally:
            server.terminate()
            server.wait(10)


if __name__ == "__main__":
    main()
