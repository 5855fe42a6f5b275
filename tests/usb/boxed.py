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
from world import Failed, say

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
    manager.forget()
    world.wait(lambda: away() > before, "a stopped box is at the bus still")
    # What was handed to another process is not taken for one's own.
    manager.begin(pid="1")
    world.wait(lambda: answers(world), "no status")
    if world.log("usbd").count("goes on with the gadget") != 6:
        raise Failed("what was another's was taken")
    say(f"restarts: 6 of the service by stop, kill and abort, and no PC saw the box go; the status was right {max(took) * 1e3:.0f} ms later at most")
