# SPDX-License-Identifier: Apache-2.0
"""Scenarios with a box behind the cable: ttfboxd on a simulated camera, in real time (README.md)."""
import http.client
import json
import os
import signal
import stat
import subprocess
import threading
import time

from manager import Manager
from world import Failed, Reader, descriptors, memory, number, quantiles, say

TOKEN = "/api/v1/session/token"
MARKED = {"X-Ttfbox": "1"}


def ttfbox(world, *arguments):
    return subprocess.run([world.ttfbox, *arguments], capture_output=True, text=True, timeout=60, check=False)


def waits(world, connection=None):
    return json.loads(world.get("/api/v1/session", connection)[1])["token_waits"]


def asked(world, connection=None, headers=None):
    """The status of asking for the token, and the token."""
    status, body = world.get(TOKEN, connection, MARKED if headers is None else headers, "POST")
    return status, json.loads(body).get("token")


def anew(world, *lines):
    """The box started again, its sockets too."""
    world.kill("daemon")
    os.unlink(world.at("http"))
    world.daemon(*lines)


def token(world):
    """Whoever is first at the cable gets the token, once; nobody else does, however they ask."""
    world.daemon()
    world.cable()
    world.box()
    world.bridge()
    world.is_healthy(2.0)
    for status, what in ((asked(world, headers={})[0], "what a page elsewhere can send"),
                         (asked(world, http.client.HTTPConnection(world.tcp, timeout=10))[0], "a client by TCP"),
                         (asked(world, headers=MARKED | {"Sec-Fetch-Site": "cross-site"})[0], "another page")):
        if status != 403:
            raise Failed(f"{what} gets {status}")
    if not waits(world) or waits(world, http.client.HTTPConnection(world.tcp, timeout=10)):
        raise Failed("it is said to wait where it cannot be had, or not where it can")
    anew(world)
    got = []
    crowd = [threading.Thread(target=lambda: got.append(asked(world))) for _ in range(8)]
    for thread in crowd:
        thread.start()
    for thread in crowd:
        thread.join(20)
    if sorted(status for status, _ in got) != [200] + [409] * 7 or (200, world.token()) not in got:
        raise Failed(f"of eight who ask at once: {got}")
    if waits(world):
        raise Failed("it waits after it was shown")
    # As a person does it, of a token that was made anew.
    world.end("bridge")
    cable, kept = "cable:" + world.at("cable"), world.at("kept")
    r = ttfbox(world, "usb", "token", "--box", cable)
    if r.returncode != 2 or "has shown its token before" not in r.stderr:
        raise Failed(f"shown twice: {r.returncode} {r.stdout}{r.stderr}")
    os.unlink(os.path.join(world.data, ".ttfbox", "token"))
    anew(world)
    r = ttfbox(world, "usb", "token", "--box", cable, "--token-file", kept)
    if r.returncode != 0 or r.stdout.strip() != world.token() or stat.S_IMODE(os.stat(kept).st_mode) != 0o600:
        raise Failed(f"the token is {r.stdout!r} {r.stderr}")
    anew(world)
    r = ttfbox(world, "usb", "token", "--box", cable, "--token-file", world.at("other"))
    if r.returncode != 2 or os.path.exists(world.at("other")):
        raise Failed(f"a restart shows it again: {r.stdout}{r.stderr}")
    with_it(world, cable, kept)
    # One of a person's own.
    with open(world.at("own"), "w", encoding="ascii") as file:
        file.write("0123456789abcdef\r\n")
    os.chmod(world.at("own"), 0o600)
    anew(world, "token_file: " + world.at("own"))
    r = ttfbox(world, "usb", "token", "--box", cable)
    if r.returncode != 2:
        raise Failed(f"a token that a person wrote is shown: {r.stdout}")
    say("token: shown to one of eight, once; by TCP, to other pages and after a restart never; with it a run begins and the time is taken")


def with_it(world, cable, kept):
    """What the token is good for; without it nothing of that."""
    world.bridge()
    plan = "interval: 500ms\ncount: 3\nshot: {exposure: 10ms}\nkeep: raw\nreserve: 0B\n"
    bearer = MARKED | {"Authorization": "Bearer " + world.token()}
    for headers, wanted in ((MARKED, 401), (bearer, 200)):
        status, body = world.get("/api/v1/plans/one", None, headers | {"Content-Type": "application/yaml"}, "PUT", plan)
        if status != wanted:
            raise Failed(f"a plan is put with {status}: {body[:300]!r}")
    status, body = world.get("/api/v1/run", None, bearer | {"Content-Type": "application/json"}, "POST", '{"plan":"one"}')
    if status != 202:
        raise Failed(f"a run is answered with {status}: {body[:300]!r}")
    trust = json.loads(world.get("/api/v1/status")[1])["time"]["trust"]
    world.end("bridge")
    r = ttfbox(world, "pull", world.at("here"), "--box", cable, "--token-file", kept)
    if r.returncode != 0 or ("took this machine's time" in r.stdout) != (trust == "none"):
        raise Failed(f"trust {trust}, and the pull says {r.stdout}{r.stderr}")
    if ("time from=host" in world.log("daemon")) != (trust == "none"):
        raise Failed(f"trust {trust}, and the box says {world.log('daemon')}")
    if "took" in ttfbox(world, "pull", world.at("here"), "--box", cable).stdout:
        raise Failed("the time is taken from somebody without the token")


# ---- the service ttfbox-usbd, as its manager starts it


def answers(world):
    try:
        world.is_healthy(1.0)
        return True
    except Failed:
        return False


def restarts(world):
    """A restart of ttfbox-usbd.service, or of ttfboxd's, is no unplugging: the manager keeps the gadget open meanwhile."""
    world.daemon()
    world.cable()
    manager = Manager(world)
    manager.begin()
    world.bridge()
    world.is_healthy(2.0)
    away = lambda: world.log("bridge").count("the box is away")
    before, took = away(), []
    for number in (signal.SIGTERM, signal.SIGKILL, signal.SIGABRT) * 2:
        manager.end(number)
        time.sleep(0.2)  # the service's RestartSec
        manager.begin()
        begun = time.monotonic()
        world.wait(lambda: answers(world), "no status after a restart", 3.0)
        took.append(time.monotonic() - begun)
    if world.log("usbd").count("goes on with the gadget as it is") != 6 or world.log("usbd").count("ready at") != 7:
        raise Failed(f"the gadget was not handed on: {world.log('usbd')}")
    if away() != before:
        raise Failed("a PC saw the box go away")
    # A restart of the box's own service: the cable's notices nothing.
    worker = world.worker()
    anew(world)
    world.wait(lambda: answers(world), "no status from the next ttfboxd", 3.0)
    if world.worker() != worker or away() != before:
        raise Failed("the cable's service did not outlive the box's")
    # Stopped, and nobody holds the gadget: it is gone.
    manager.end(signal.SIGTERM)
    # What was handed to another process is not taken for one's own.
    manager.begin(pid="1")
    world.wait(lambda: answers(world), "no status")
    if world.log("usbd").count("goes on with the gadget") != 6:
        raise Failed("what was another's was taken")
    manager.end(signal.SIGTERM)
    manager.forget()
    world.wait(lambda: away() > before, "a stopped box is at the bus still")
    say(f"restarts: 6 of the service by stop, kill and abort, and no PC saw the box go; the status was right {max(took) * 1e3:.0f} ms later at most")


# ---- beside a capture


def capture(world, interval_ms=500):
    """A run under way, until the world ends; its dataset is "run"."""
    with open(world.at("run.yaml"), "w", encoding="ascii") as file:
        file.write("interval: %dms\ncount: 100000\nshot: {exposure: 10ms}\nkeep: raw\nreserve: 0B\n" % interval_ms)
    world.daemon("plan: " + world.at("run.yaml"))
    world.wait(lambda: len(slots(world)) >= 3, "nothing is captured", 30)


def slots(world):
    try:
        with open(os.path.join(world.data, "run", "records.jsonl"), encoding="utf-8") as file:
            records = [json.loads(line) for line in file.read().split("\n")[:-1]]
    except OSError:
        return []
    return [r for r in records if r["type"] == "slot"]


def none_lost(world):
    """Stops the run. All slots that it had, but those that passed while the program began."""
    status, _ = world.get("/api/v1/run/stop", None, MARKED | {"Authorization": "Bearer " + world.token()}, "POST")
    if status != 202:
        raise Failed(f"the run is not stopped: {status}")
    world.wait(lambda: json.loads(world.get("/api/v1/status")[1])["state"] not in ("capturing", "stopping", "paused"), "the run does not end", 30)
    got = slots(world)
    lost = [r for r in got if r["result"] != "captured" and r.get("reason") not in
            ("the program was not running", "the box was getting ready")]
    if lost or [r["index"] for r in got] != list(range(len(got))):
        raise Failed(f"of {len(got)} slots {len(lost)} were lost: {lost[:3]}")
    return len(got)


class Costs:
    """What processes hold, before and after."""

    def __init__(self, **pids):
        self.pids = pids
        self.before = {name: (descriptors(pid), memory(pid)) for name, pid in pids.items()}

    def check(self, world, mib=1.0):
        told = []
        for name, pid in self.pids.items():
            fds, held = self.before[name]
            # Streams that were cut off are tidied away, some by the server's end of them.
            world.wait(lambda: descriptors(pid) <= fds, f"{name} has more than {fds} descriptors", 10)
            grown = memory(pid) - held
            if grown > mib:
                raise Failed(f"{name} has grown by {grown:.1f} MiB from {held:.1f} MiB")
            told.append(f"{name} {fds} descriptors, {held:.1f} MiB, {grown:+.2f} MiB")
        return "; ".join(told)


def a_kill(world, paths):
    readers = [Reader(world, path) for path in paths]
    for reader in readers:
        reader.start()
    time.sleep(world.random.uniform(0, 0.12))
    world.kill("bridge")
    world.bridge()
    world.is_healthy(2.0)
    for reader in readers:
        reader.end()
        reader.join(10)


def an_unplug(world, paths):
    readers = [Reader(world, path) for path in paths]
    for reader in readers:
        reader.start()
    time.sleep(world.random.uniform(0, 0.12))
    if world.random.random() < 0.3:
        world.tell("lose-down")
    world.tell("unplug")
    time.sleep(world.random.uniform(0, 0.05))
    world.tell("replug")
    for reader in readers:
        reader.end()
        reader.join(10)
    world.wait(lambda: answers(world), "no status after an unplug", 5.0)


def captures(world):
    """Kills and unplugs beside a capture: no slot is lost by them, and nobody holds more afterwards than before."""
    world.in_memory()
    world.dataset()
    paths = [world.file("noise", 16 << 20), world.file("small", 700), "/api/v1/events", "/api/v1/datasets/run/records"]
    capture(world)
    world.cable()
    world.box()
    world.bridge()
    begun = time.monotonic()
    a_kill(world, paths)
    an_unplug(world, paths)
    usbd = {"the keeper": world.processes["usbd"].pid, "the worker": world.worker()}
    costs = Costs(**usbd)
    n_kills = number("CAPTURE_KILLS", 20)
    for _ in range(n_kills):
        a_kill(world, paths)
    killed = costs.check(world)
    an_unplug(world, paths)
    costs = Costs(bridge=world.processes["bridge"].pid, **usbd)
    n_unplugs = number("CAPTURE_UNPLUGS", 10)
    for _ in range(n_unplugs):
        an_unplug(world, paths)
    unplugged = costs.check(world)
    if world.worker() != usbd["the worker"]:
        raise Failed("the worker was another one at the end")
    s = time.monotonic() - begun
    n = none_lost(world)
    say(f"captures: {n} slots, none lost by {n_kills + 1} kills and {n_unplugs + 2} unplugs in {s:.0f} s\n    after the kills: {killed}\n"
        f"    after the unplugs: {unplugged}")


def latency(world):
    """The status of a box that captures, while a large file is pulled, beside a stream of events and one that nobody reads."""
    world.in_memory()
    world.dataset()
    mib = number("MIB", 64)
    path = world.file("large", mib << 20)
    capture(world)
    world.cable()
    world.box()
    world.bridge()
    world.tell("throttle %d" % number("MBPS", 35))
    events = Reader(world, "/api/v1/events")
    stalled = Reader(world, path, reads=False)
    reader = Reader(world, path)
    for client in (events, stalled, reader):
        client.start()
    took, begun = [], time.monotonic()
    c = world.connect()
    while reader.bytes < mib << 20:
        asked_at = time.monotonic()
        status, body = world.get("/api/v1/status", c)
        took.append(time.monotonic() - asked_at)
        if status != 200 or json.loads(body)["state"] != "capturing" or not reader.is_alive():
            raise Failed(f"the status is {status}, {body[:200]!r}")
        time.sleep(0.01)
    s, came = time.monotonic() - begun, reader.bytes
    told = events.bytes
    for client in (events, stalled, reader):
        client.end()
    if told < 100 * s:
        raise Failed(f"{told} bytes of events in {s:.0f} s")
    world.tell("throttle 0")
    n = none_lost(world)
    q = quantiles(took)
    most = number("P99_MS", 0)
    if most and q["p99"] * 1e3 > most:
        raise Failed(f"p99 of the status is {q['p99'] * 1e3:.1f} ms, more than {most} ms")
    say(f"latency: while {came >> 20} MiB were pulled at {came / 1e6 / s:.1f} MB/s beside {told} bytes of events and a stalled stream, {len(took)} times "
        f"the status: p50 {q['p50'] * 1e3:.1f} ms, p99 {q['p99'] * 1e3:.1f} ms, max {q['max'] * 1e3:.1f} ms; {n} slots, none lost")
