#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A box's USB on a simulated cable (README.md).

    usb.py TTFBOX USBD TTFBOXD CABLE [SCENARIO...]     all of them, or those named

TTFBOX_USB_KILLS, TTFBOX_USB_UNPLUGS, TTFBOX_USB_SIZES=all, TTFBOX_USB_MIB (to pull while the status is asked for),
TTFBOX_USB_SLOTS and TTFBOX_USB_SEED make a campaign of it; without, each takes some seconds.
"""
import http.client
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time

import boxed
from world import Failed, HEALTH, Reader, World, digest, memory, number, quantiles, say


# ---- what arrives


def sizes(world):
    """Files of every size arrive as they are."""
    world.dataset()
    whole = world.random.randbytes((1 << 20) + 2)
    world.file("whole", len(whole), whole)
    every = os.environ.get("TTFBOX_USB_SIZES") == "all"
    small = range(4097) if every else list(range(0, 4097, 61)) + [0, 1, 63, 64, 65, 511, 512, 513]
    for n in small:
        world.file("f%d" % n, n, whole[:n])
    world.all()
    c = world.connect()
    for n in small:
        status, body = world.get("/api/v1/datasets/grass/files/f%d" % n, c)
        if status != 200 or body != whole[:n]:
            raise Failed(f"a file of {n} bytes comes as {status} and {len(body)} bytes")
    step = 64 if every else 8192
    larger = [n + d for n in range(step, (1 << 20) + 1, step) for d in (-1, 0, 1)]
    for n in larger:
        status, body = world.get("/api/v1/datasets/grass/files/whole", c, {"Range": "bytes=0-%d" % (n - 1)})
        if status != 206 or body != whole[:n]:
            raise Failed(f"{n} bytes of a file come as {status} and {len(body)} bytes")
    say(f"sizes: {len(small)} files of 0 to 4096 bytes, {len(larger)} parts of up to 1 MiB, all as they are")


# ---- what dies


def kills(world):
    """The PC's side killed at any moment while three streams run: the next status is right, at once."""
    world.dataset()
    replies = b'HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\nno' * 500
    paths = [world.file("replies", 64 << 20, replies), world.file("noise", 64 << 20),
             world.file("small", 700)]
    world.all()
    took, n = [], number("KILLS", 20)
    for _ in range(n):
        readers = [Reader(world, path) for path in paths]
        for reader in readers:
            reader.start()
        time.sleep(world.random.uniform(0, 0.12))
        world.kill("bridge")
        world.bridge()
        took.append(world.is_healthy(1.0))
        for reader in readers:
            reader.end()
            reader.join(10)
    if not any("joined" in line for line in world.log("usbd").splitlines()):
        raise Failed("nothing was ever joined")
    q = quantiles(took)
    say(f"kills: {n}, each time the status was right, p50 {q['p50'] * 1e3:.1f} ms, p99 {q['p99'] * 1e3:.1f} ms, "
        f"max {q['max'] * 1e3:.1f} ms after the next program began")


def answers(world):
    try:
        world.is_healthy(1.0)
        return True
    except Failed:
        return False


def usbd_dies(world):
    """The box's worker killed at any moment: another takes over at the same gadget, and clients come through again."""
    world.dataset()
    path = world.file("noise", 64 << 20)
    world.all()
    took, n = [], number("BOX_KILLS", 5)
    for _ in range(n):
        reader = Reader(world, path)
        reader.start()
        time.sleep(world.random.uniform(0.02, 0.15))
        worker = world.worker()
        os.kill(worker, signal.SIGKILL)
        begun = time.monotonic()
        reader.join(5)
        if reader.is_alive():
            raise Failed("a client is not told that the box's side has gone")
        # A client of the moment in which the new one begins may be sent away once more.
        world.wait(lambda: answers(world), "no status", 3.0)
        took.append(time.monotonic() - begun)
        reader.end()
        if world.worker() in (worker, None):
            raise Failed("no other worker was started")
    if world.log("usbd").count("ready at") != 1:
        raise Failed("the gadget was given up")
    say(f"usbd dies: {n} times, the status was right again {max(took) * 1e3:.0f} ms later at most")


def daemon_dies(world):
    """The server killed in the middle of a body: the client is told within a second, and finds the next server."""
    world.dataset()
    path = world.file("noise", 256 << 20)
    world.all()
    worst = 0.0
    for _ in range(5):
        world.tell("throttle 200")
        reader = Reader(world, path)
        reader.start()
        world.wait(lambda: reader.bytes > 1 << 20, "nothing comes")
        world.kill("serve")
        begun = time.monotonic()
        reader.join(5)
        worst = max(worst, time.monotonic() - begun)
        if reader.is_alive() or worst > 1.0:
            raise Failed(f"the client is told after {worst:.2f} s, or not at all")
        os.unlink(world.at("http"))
        world.serve()
        world.tell("throttle 0")
        world.is_healthy(1.0)
    say(f"daemon dies: the client was told {worst * 1e3:.0f} ms later at most")


def unplugs(world):
    """The cable out and in at any moment of a pull: it goes on, and what it brings is the same to the bit."""
    folder = world.dataset(6, 1200, 800)  # of pictures of 6 MB, so that most cuts are within one
    before = digest(folder)
    size = sum(os.path.getsize(os.path.join(base, name)) for base, _, names in os.walk(folder) for name in names)
    world.serve()
    world.cable()
    world.box()
    total = number("UNPLUGS", 8)
    done, again, pulls = 0, 0, 0
    while done < total:
        pulls += 1
        world.tell("throttle %g" % (size / 1e6 / 2.0))
        dest = world.at("here%d" % pulls)
        pull = subprocess.Popen([world.ttfbox, "pull", dest, "--box", "cable:" + world.at("cable"), "--follow", "--json"],
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        here = 0
        while done < total and pull.poll() is None and here < 20:
            time.sleep(world.random.uniform(0.02, 0.25))
            if pull.poll() is not None:
                break
            if world.random.random() < 0.3:
                world.tell("lose-down")
            world.tell("unplug")
            time.sleep(world.random.uniform(0, 0.05))
            world.tell("replug")
            done += 1
            here += 1
        world.tell("throttle 0")
        out, _ = pull.communicate(timeout=120)
        result = json.loads(out)
        if pull.returncode != 0 or digest(os.path.join(dest, "grass")) != before:
            raise Failed(f"what was pulled is not the same: {out}")
        extra = result["bytes"] - size
        again = max(again, extra / max(1, here))
        if extra > (1 << 20) * max(1, here):
            raise Failed(f"{extra} bytes were sent again for {here} unplugs")
    say(f"unplugs: {done} in {pulls} pulls of {size / 1e6:.1f} MB, all the same to the bit; "
        f"sent again for each: {again / 1e3:.0f} kB at most, 1 MiB allowed")


def sleeps(world):
    """A bus that sleeps for longer than 3 s ends the box's streams; awake, it serves again. A nap ends nothing."""
    world.dataset()
    path = world.file("noise", 32 << 20)
    world.all()
    world.tell("throttle 20")
    reader = Reader(world, path)
    reader.start()
    world.wait(lambda: reader.bytes > 0, "nothing comes")
    world.tell("suspend")
    time.sleep(0.5)
    world.tell("resume")
    time.sleep(0.3)
    had = reader.bytes
    world.wait(lambda: reader.bytes > had, "a nap ended the stream")
    sockets = lambda: len(os.listdir(f"/proc/{world.worker()}/fd"))
    joined = sockets()
    world.tell("suspend")
    world.wait(lambda: sockets() < joined, "a sleeping box keeps its streams", 5)
    world.tell("resume")
    world.tell("throttle 0")
    reader.join(5)
    if reader.is_alive():
        raise Failed("the client of a stream that the box ended is not told")
    took = world.is_healthy(2.0)
    say(f"sleeps: a nap ended nothing, a sleep the streams; the status came {took * 1e3:.0f} ms after waking")


# ---- what it costs


def greedy(world):
    """A host that opens every stream and never reads makes the box hold its windows, and no more."""
    world.dataset()
    path = world.file("noise", 8 << 20)
    world.all()
    world.is_healthy(1.0)
    before = memory(world.worker())
    # The bridge's own windows fill first, then the box's; so the clients' sockets are never read.
    stalled = [Reader(world, path, reads=False) for _ in range(31)]
    for reader in stalled:
        reader.start()
    time.sleep(1.5)
    grown = memory(world.worker()) - before
    if grown > 33:
        raise Failed(f"the box holds {grown:.1f} MiB more for 31 streams")
    took = world.is_healthy(1.0)
    for reader in stalled:
        reader.end()
    time.sleep(0.5)
    left = memory(world.worker()) - before
    if left > 4:
        raise Failed(f"{left:.1f} MiB are left when they are gone")
    say(f"greedy: 31 stalled streams cost the box {grown:.1f} MiB (32 at most), {left:.1f} MiB when they had gone; "
        f"the status came in {took * 1e3:.1f} ms beside them")


def drain(world, path, direct=False):
    """MB/s of one body that is thrown away."""
    c = world.connect(direct=direct)
    buffer = bytearray(1 << 20)
    begun, n = time.monotonic(), 0
    c.request("GET", path)
    answer = c.getresponse()
    while got := answer.readinto(buffer):
        n += got
    c.close()
    return n / 1e6 / (time.monotonic() - begun)


def speed(world):
    """Bodies thrown away, through the cable as fast as it goes and throttled; and straight from the server."""
    world.dataset()
    path = world.file("large", number("MIB", 64) << 20)
    world.all()
    drain(world, path)
    straight = max(drain(world, path, direct=True) for _ in range(3))
    fast = max(drain(world, path) for _ in range(3))
    ratios = {}
    for limit in (35, 100):
        world.tell("throttle %d" % limit)
        ratios[limit] = drain(world, path) / limit
    say(f"speed: {fast:.0f} MB/s through the simulated cable, {straight:.0f} MB/s straight from the server; throttled to 35 MB/s "
        f"{ratios[35]:.3f} of it, to 100 MB/s {ratios[100]:.3f}")


def listing(world):
    """The records of a dataset of many slots."""
    slots = number("SLOTS", 300)
    world.dataset(slots)
    world.all()
    path = "/api/v1/datasets/grass"
    world.get("/api/v1/datasets")
    took = []
    for _ in range(5):
        begun = time.monotonic()
        world.get("/api/v1/datasets")
        world.get(path)
        status, body = world.get(path + "/records")
        took.append(time.monotonic() - begun)
        lines = body.count(b'"type":"slot"')
        if status != 200 or lines != slots:
            raise Failed(f"{lines} slots of {slots}")
    most = number("LISTING_MS", 0)
    if most and max(took) * 1e3 > most:
        raise Failed(f"{slots} slots take {max(took):.3f} s, more than {most / 1e3:.3f} s")
    say(f"listing: {slots} slots, {len(body) / 1e6:.1f} MB of records, in {min(took) * 1e3:.0f} to {max(took) * 1e3:.0f} ms")


def strangers(world):
    """Others are kept out: another program while one has the box; a PC that pulls from a box that is not there."""
    world.dataset()
    world.all()
    world.is_healthy(1.0)

    def refused(*arguments):
        r = subprocess.run([world.ttfbox, *arguments], capture_output=True, text=True, timeout=20, check=False)
        if r.returncode == 0:
            raise Failed(f"{arguments} is not refused: {r.stdout}")
        return r.stderr

    if "another program has this box" not in refused("pull", world.at("no"), "--box", "cable:" + world.at("cable")):
        raise Failed("it is not said that another program has the box")
    if oct(os.stat(world.at("pc")).st_mode & 0o777) != "0o600":
        raise Failed("others may use the bridge's socket")
    # The server's socket on a box is its group's, where ttfbox-usbd belongs to that.
    os.mkdir(world.at("group"))
    os.chmod(world.at("group"), 0o2770)
    world.start("other", world.ttfbox, "serve", world.data, "--listen", "unix:" + world.at("group/http"),
                ready=world.at("group/http"))
    if oct(os.stat(world.at("group/http")).st_mode & 0o777) != "0o660":
        raise Failed("the group may not use the server's socket")
    # Not so the bridge's, wherever it is; and without --listen it is where the user alone comes in.
    world.end("bridge")
    session = subprocess.Popen([world.ttfbox, "usb", "--box", "cable:" + world.at("cable"), "--json"], text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=os.environ | {"XDG_RUNTIME_DIR": world.at("group")})
    try:
        if json.loads(session.stdout.readline())["listening"] != "unix:" + world.at("group/ttfbox-usb"):
            raise Failed("'ttfbox usb' listens elsewhere")
        if oct(os.stat(world.at("group/ttfbox-usb")).st_mode & 0o777) != "0o600":
            raise Failed("the group may use the bridge's socket")
    finally:
        session.terminate()
        session.wait(10)
    world.tell("unplug")
    if "no box is plugged in" not in refused("pull", world.at("no"), "--box", "cable:" + world.at("cable")):
        raise Failed("it is not said that there is no box")
    if "others would reach the box" not in refused("usb", "--box", "cable:" + world.at("cable"), "--listen", "0.0.0.0:0"):
        raise Failed("the box is offered to everybody")
    world.tell("replug")
    r = subprocess.run([world.ttfbox, "pull", world.at("here"), "--box", "cable:" + world.at("cable"), "--json"],
                       capture_output=True, text=True, timeout=30, check=False)
    if r.returncode != 0 or digest(world.at("here/grass")) != digest(world.at("data/grass")):
        raise Failed(f"what was pulled is not the same: {r.stdout}{r.stderr}")
    # A client by TCP, as a browser is one.
    bridge = subprocess.Popen([world.ttfbox, "usb", "--box", "cable:" + world.at("cable"), "--listen", "127.0.0.1:0", "--json"],
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        host, port = json.loads(bridge.stdout.readline())["listening"].rsplit(":", 1)
        c = http.client.HTTPConnection(host, int(port), timeout=5)
        c.request("GET", HEALTH)
        if c.getresponse().read()[:10] != b'{"ok":true':
            raise Failed("the status by TCP is another")
        half = socket.create_connection((host, int(port)), timeout=5)
        half.sendall(b"GET %s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n" % HEALTH.encode())
        half.shutdown(socket.SHUT_WR)
        answer = b""
        while piece := half.recv(4096):
            answer += piece
        if b'{"ok":true' not in answer:
            raise Failed(f"who has ended asking gets no answer: {answer!r}")
    finally:
        bridge.terminate()
        bridge.wait(10)
    say("strangers: a second program, a missing box, an address of everybody's are refused; TCP and half-closed clients are served")


class LaterBox(threading.Thread):
    """A box of another version of the protocol: it answers resets, and says so in its HELLO."""

    def __init__(self, world, version):
        super().__init__(daemon=True)
        self.version, self.out = version, None
        self.control = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.control.connect(world.at("cable"))
        self.control.send(struct.pack("=QQ", ord("B"), 0))

    def run(self):
        while True:
            message, fds, _, _ = socket.recv_fds(self.control, 16, 2)
            if len(message) < 16:
                return
            kind, nonce = struct.unpack("=QQ", message)
            if chr(kind) == "U":
                os.close(fds[0])
                self.out = socket.socket(fileno=fds[1])
            elif chr(kind) == "X":
                self.control.send(struct.pack("=QQ", ord("A"), nonce))
                self.out.send(struct.pack("<HBBI", 0, 6, 0, 0))
                self.out.send(struct.pack("<HBBIHHIQ", 0, 1, 0, 16, self.version, 32, 1 << 18, nonce))

    def end(self):
        self.control.shutdown(socket.SHUT_RDWR)
        self.join(5)


def versions(world):
    """A box of another version is no box to wait for: it is said at once, by all that would use it."""
    world.cable()
    box = LaterBox(world, 2)
    box.start()
    worst = 0.0
    for command in (["pull", world.at("no")], ["pull", world.at("no"), "--follow"], ["pull", world.at("no"), "--only", "grass"],
                    ["pull", "--list"], ["usb", "--listen", "unix:" + world.at("pc")]):
        begun = time.monotonic()
        r = subprocess.run([world.ttfbox, *command, "--box", "cable:" + world.at("cable")], capture_output=True, text=True,
                           timeout=60, check=False)
        worst = max(worst, time.monotonic() - begun)
        if r.returncode != 1 or "speaks another version of the protocol" not in r.stderr or worst > 3.0:
            raise Failed(f"{command} ends with {r.returncode} after {worst:.1f} s: {r.stderr}")
    box.end()
    say(f"versions: a box of another version is told from one that is away, after {worst * 1e3:.0f} ms at most")


SCENARIOS = {"sizes": sizes, "kills": kills, "usbd-dies": usbd_dies, "daemon-dies": daemon_dies, "unplugs": unplugs,
             "sleeps": sleeps, "greedy": greedy, "strangers": strangers, "versions": versions, "token": boxed.token, "restarts": boxed.restarts,
             "captures": boxed.captures, "latency": boxed.latency, "speed": speed, "listing": listing}


def main():
    programs, asked = sys.argv[1:5], sys.argv[5:] or list(SCENARIOS)
    failed = 0
    for name in asked:
        with World(programs, number("SEED", 20261126)) as world:
            try:
                SCENARIOS[name](world)
            except (Failed, OSError, subprocess.SubprocessError, http.client.HTTPException) as error:
                say(f"{name}: FAILED: {error}")
                failed = 1
    return failed


if __name__ == "__main__":
    sys.exit(main())
