#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""pull_cuts.py TTFBOX [N [SEED]]: 'ttfbox pull' over TCP with N connections cut at random bytes, N kills of the program at random moments, and
N bits turned over on the way. After each pull what is there is looked at; each copy that is sealed is compared with the box's."""
import hashlib
import json
import os
import random
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time

FEW = 40  # pulls that one copy may take, before it is begun anew


class Wire:
    """Stands between a client and a box. Counts what it does to answers."""

    def __init__(self, box, chance):
        self.box, self.chance, self.lock = box, chance, threading.Lock()
        self.kind, self.cuts, self.flips = None, 0, 0
        self.door = socket.create_server(("127.0.0.1", 0), backlog=64)
        threading.Thread(target=self.accept, daemon=True).start()

    def where(self):
        return "http://127.0.0.1:%d" % self.door.getsockname()[1]

    def accept(self):
        while True:
            client, _ = self.door.accept()
            box = socket.create_connection(self.box)
            threading.Thread(target=self.forward, args=(client, box), daemon=True).start()
            threading.Thread(target=self.answer, args=(box, client), daemon=True).start()

    @staticmethod
    def end(*sockets):
        for s in sockets:
            try:
                s.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def forward(self, client, box):
        try:
            while data := client.recv(65536):
                box.sendall(data)
        except OSError:
            pass
        self.end(client, box)

    def flip(self, data):
        """One bit of a body, now and then. One of a header is another matter."""
        first = data.find(b"\r\n\r\n") + 4 if b"HTTP/1.1 " in data else 0
        with self.lock:
            if first < 4 and first > 0 or first >= len(data) or self.chance.random() >= 0.1:
                return
            data[self.chance.randrange(first, len(data))] ^= 1 << self.chance.randrange(8)
            self.flips += 1

    def answer(self, box, client):
        with self.lock:
            left = self.chance.randrange(200, 120000) if self.kind == "cuts" else 1 << 60
        try:
            while data := bytearray(box.recv(min(left, 65536))):
                left -= len(data)
                if self.kind == "flips":
                    self.flip(data)
                client.sendall(data)
                if left == 0:
                    with self.lock:
                        self.cuts += 1
                    break
        except OSError:
            pass
        self.end(client, box)
        box.close()
        client.close()


def sums(folder):
    found = {}
    for base, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(base, name)
            with open(path, "rb") as file:
                found[os.path.relpath(path, folder)] = hashlib.sha256(file.read()).hexdigest()
    return found


class Campaign:
    def __init__(self, ttfbox, n, seed):
        self.ttfbox, self.n, self.seed = ttfbox, n, seed
        self.chance = random.Random(seed)
        self.folder = tempfile.mkdtemp(prefix="ttfbox-cuts-")
        self.data, self.here = os.path.join(self.folder, "data"), os.path.join(self.folder, "here")
        self.copy = os.path.join(self.here, "grass")
        self.phase, self.pulls, self.copies, self.begun_anew, self.said = "", 0, 0, 0, []

    def run(self, *arguments):
        return subprocess.run([self.ttfbox, *arguments], capture_output=True, text=True, timeout=120, check=False)

    def begin(self):
        plan = os.path.join(self.folder, "plan.yaml")
        with open(plan, "w", encoding="ascii") as file:
            file.write("interval: 1h\ncount: 10\nlamps: {mode: continuous}\nshots:\n  - {stream: main, channel: white, "
                       "lamps: {left: 100%, right: 100%}, exposure: 20ms}\nkeep: both\nmains: 50Hz\n")
        r = self.run("capture", plan, "--board", "sim-small", "--set", "sim.sensor.width=96px", "--set", "sim.sensor.height=64px",
                     "-o", os.path.join(self.data, "grass"))
        assert r.returncode == 0, r.stderr
        r = self.run("note", os.path.join(self.data, "grass"), "watered", "--slots", "3")  # no list has its hash
        assert r.returncode == 0, r.stderr
        self.whole = sums(os.path.join(self.data, "grass"))
        self.server = subprocess.Popen([self.ttfbox, "serve", self.data, "--listen", "127.0.0.1:0", "--json"], stdout=subprocess.PIPE,
                                       stderr=subprocess.DEVNULL, text=True)
        host, port = json.loads(self.server.stdout.readline())["listening"].rsplit(":", 1)
        self.wire = Wire((host, int(port)), self.chance)

    def end(self, keep):
        """keep: what failed is looked at by a person."""
        if hasattr(self, "server"):
            self.server.kill()
            self.server.wait()
        if keep:
            print(f"kept: {self.folder} (phase {self.phase}, pull {self.pulls}, copy {self.copies + 1})", flush=True)
            self.tell()
        else:
            shutil.rmtree(self.folder, ignore_errors=True)

    def tell(self):
        """How the copy came to be what it is: what its last pulls said, what lies there, what 'verify' says of it."""
        for words in self.said:
            print(words, flush=True)
        for name, digest in sorted(sums(self.copy).items()):
            mark = "" if self.whole.get(name) == digest else "  (not the box's)"
            print(f"{os.path.getsize(os.path.join(self.copy, name)):9} {digest[:16]} {name}{mark}", flush=True)
        r = self.run("verify", self.copy, "--json")
        print(f"verify --json: {r.returncode} {r.stdout}{r.stderr}", flush=True)

    def look(self, sealed):
        """What is there by its final name is the box's; a copy that is said to be whole is."""
        if sealed:
            # NAME.tmp belongs to no dataset.
            there = {name: digest for name, digest in sums(self.copy).items() if not name.endswith(".tmp")}
            self.left_over += any(name.endswith(".tmp") for _, _, names in os.walk(self.copy) for name in names)
            wrong = sorted(set(there.items()) ^ set(self.whole.items()))
            assert not wrong, f"a copy is said to be sealed, and differs: {wrong[:4]}"
            r = self.run("verify", self.copy)
            assert r.returncode == 0, f"a copy is sealed and the box's to the bit, and 'verify' refuses it: {r.returncode} {r.stdout}{r.stderr}"
            self.copies += 1
            return
        # Of a program that was killed a small file can be half of it, until the next pull: no line names it yet, and 'verify' looks at those.
        for name, digest in sums(self.copy).items() if self.phase != "kills" and os.path.isdir(self.copy) else ():
            if name.startswith(("frames/", "raw/")) and not name.endswith(".tmp"):
                assert digest == self.whole.get(name), f"{name} is there by its name, and is not the box's"

    def pull(self, where, kill_after=None):
        """One pull, looked at. True: the copy is whole."""
        p = subprocess.Popen([self.ttfbox, "pull", self.here, "--box", where, "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if kill_after is not None:
            time.sleep(kill_after)
            p.kill()
        out, err = p.communicate(timeout=120)
        self.pulls += 1
        self.said = self.said[-FEW:] + [f"pull {self.pulls} ({self.phase}, {self.wire.cuts} cuts, {self.wire.flips} flips, "
                                        f"killed after {kill_after} s): {p.returncode} {out}{err}"]
        assert p.returncode in (0, 1, 2, 3) or kill_after is not None, f"it ended with {p.returncode}: {err}"
        sealed = p.returncode == 0 and json.loads(out)["sealed"] == 1
        self.look(sealed)
        # No dataset yet, or one; never a broken one. Lines that a bit was turned over in are not sealed: the seal would not fit. A file at which the
        # connection ended three times without a further byte passes for unreadable on the box (exit 3): it is left out, said, and comes the next time.
        if not sealed and self.phase != "flips" and os.path.exists(os.path.join(self.copy, "records.jsonl")):
            r = self.run("verify", self.copy)
            self.left_out |= p.returncode == 3
            self.unreadable += p.returncode == 3
            assert r.returncode == 0 or (self.left_out and r.returncode == 3), \
                f"what is there is no whole dataset: {r.returncode} {r.stdout}{r.stderr} behind a pull that said {out}{err}"
        return sealed

    def many(self, kind, count, once):
        """Until so many have happened, copy after copy. Each is finished in the end, over a wire that does nothing."""
        self.phase = self.wire.kind = kind
        self.pulls = self.copies = self.begun_anew = self.unreadable = self.left_over = 0
        self.left_out = False
        begun, own = time.monotonic(), 0
        while count() < self.n:
            own += 1
            sealed = once()
            if sealed or own >= FEW:
                self.wire.kind = None
                if not sealed:
                    self.finish()
                self.wire.kind, own, self.left_out = kind, 0, False
                shutil.rmtree(self.here, ignore_errors=True)
                self.said.clear()
        self.wire.kind = None
        if os.path.isdir(self.here):
            self.finish()
        shutil.rmtree(self.here, ignore_errors=True)
        print(f"{kind}: {count()} in {self.pulls} pulls, {self.copies} sealed copies, each the same to the bit; "
              f"{self.begun_anew} refused as another's and begun anew, {self.unreadable} pulls that left a file out, {self.left_over} copies with a .tmp left; {time.monotonic() - begun:.0f} s", flush=True)

    def finish(self):
        """A copy that was never finished goes on over a good wire; a manifest with a wrong bit is another dataset's, and is refused."""
        if not self.pull(self.wire.where()):
            assert self.phase == "flips", "it does not go on over a good wire"
            self.begun_anew += 1

    def go(self):
        self.begin()
        where = self.wire.where()
        self.many("cuts", lambda: self.wire.cuts, lambda: self.pull(where))
        begun = time.monotonic()
        self.pull(where)
        took = time.monotonic() - begun
        shutil.rmtree(self.here)
        killed = [0]

        def kill():
            killed[0] += 1
            return self.pull(where, self.chance.uniform(0, 1.2 * took))

        self.many("kills", lambda: killed[0], kill)
        self.many("flips", lambda: self.wire.flips, lambda: self.pull(where))


def main():
    n = int(sys.argv[2]) if len(sys.argv) > 2 else 1000
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 20261126
    campaign = Campaign(sys.argv[1], n, seed)
    keep = True
    try:
        campaign.go()
        keep = False
    except (AssertionError, subprocess.TimeoutExpired) as wrong:
        print(f"FAILED (seed {seed}): {wrong or repr(wrong)}", flush=True)
    finally:
        campaign.end(keep)
    return int(keep)


if __name__ == "__main__":
    sys.exit(main())
