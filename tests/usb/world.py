# SPDX-License-Identifier: Apache-2.0
"""A server, a box's ttfbox-usbd, a simulated cable and a PC's bridge, as processes that tests kill, pull and measure."""
import hashlib
import http.client
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time

HEALTH = "/api/v1/health"


class Failed(Exception):
    pass


class UnixConnection(http.client.HTTPConnection):
    def __init__(self, path, timeout=30):
        super().__init__("localhost", timeout=timeout)
        self.path = path

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.settimeout(self.timeout)
        self.sock.connect(self.path)


def memory(pid):
    """MiB that a process has in memory."""
    with open(f"/proc/{pid}/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS")) / 1024


def descriptors(pid):
    return len(os.listdir(f"/proc/{pid}/fd"))


def number(name, default):
    return int(os.environ.get("TTFBOX_USB_" + name, default))


class Reader(threading.Thread):
    """A client that reads a path again and again until its connection ends, as fast as it comes or not at all."""

    def __init__(self, world, path, reads=True):
        super().__init__(daemon=True)
        self.connection, self.path, self.reads, self.bytes = world.connect(), path, reads, 0
        self.go_on = True

    def run(self):
        try:
            while self.go_on:
                self.connection.request("GET", self.path)
                answer = self.connection.getresponse()
                if not self.reads:
                    return
                while self.go_on and (piece := answer.read1(65536)):
                    self.bytes += len(piece)
        except (OSError, ValueError, AttributeError, http.client.HTTPException):
            pass

    def end(self):
        self.go_on = False
        try:
            self.connection.sock.shutdown(socket.SHUT_RDWR)  # an answer that is kept keeps it open otherwise
            self.connection.close()
        except (OSError, AttributeError):
            pass


class World:
    """Everything in one temporary folder; ended with the with statement."""

    def __init__(self, programs, seed):
        self.ttfbox, self.usbd, self.daemon_program, self.cable_program = programs
        self.random = random.Random(seed)
        self.folder = tempfile.mkdtemp(prefix="ttfbox-usb-")
        self.data = self.at("data")
        os.mkdir(self.data)
        self.processes = {}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for name in list(self.processes):
            self.end(name)
        shutil.rmtree(self.folder, ignore_errors=True)
        shutil.rmtree(self.data, ignore_errors=True)

    def at(self, name):
        return os.path.join(self.folder, name)

    def in_memory(self):
        """The data lies in memory: whether a slot is missed is not for a disk to say that is busy otherwise."""
        if os.access("/dev/shm", os.W_OK):
            self.data = tempfile.mkdtemp(prefix="ttfbox-usb-", dir="/dev/shm")

    # ---- processes

    def start(self, name, *command, ready=None, **more):
        log = open(self.at(name + ".log"), "ab")
        self.processes[name] = subprocess.Popen(command, stdout=log, stderr=log, **more)
        log.close()
        if ready:
            self.wait(lambda: self.listens(ready), f"{name} is not ready")

    @staticmethod
    def listens(path):
        """A socket's name is there before somebody listens."""
        for kind in (socket.SOCK_STREAM, socket.SOCK_SEQPACKET):
            with socket.socket(socket.AF_UNIX, kind) as probe:
                try:
                    probe.connect(path)
                    return True
                except OSError:
                    pass
        return False

    def kill(self, name, number=signal.SIGKILL):
        process = self.processes.pop(name)
        process.send_signal(number)
        return process.wait(20)

    def end(self, name):
        process = self.processes[name]
        self.kill(name, signal.SIGTERM if process.poll() is None else signal.SIGKILL)

    def log(self, name):
        with open(self.at(name + ".log"), encoding="utf-8", errors="replace") as file:
            return file.read()

    def wait(self, true, what, seconds=10.0):
        until = time.monotonic() + seconds
        while not true():
            if time.monotonic() > until:
                raise Failed(f"{what} after {seconds} s")
            time.sleep(0.005)

    def serve(self):
        self.start("serve", self.ttfbox, "serve", self.data, "--listen", "unix:" + self.at("http"), ready=self.at("http"))

    def daemon(self, *lines):
        """ttfboxd on a simulated camera in real time; lines: more of its configuration."""
        with open(self.at("box.yaml"), "w", encoding="ascii") as file:
            file.write("board: bench\ncameras: {main: {backend: sim}}\nclock: {backend: machine}\nlock: %s\nsim:\n  daylight: 1\n"
                       "  sensor: {width: 96px, height: 64px}\n  timing: {exposure_max: 100ms}\n" % self.at("lock"))
        with open(self.at("ttfboxd.yaml"), "w", encoding="ascii") as file:
            file.write("board: %s\ndata: %s\nlisten: [\"127.0.0.1:0\", \"unix:%s\"]\n" % (self.at("box.yaml"), self.data, self.at("http")))
            file.write("".join(line + "\n" for line in lines))
        self.start("daemon", self.daemon_program, "--config", self.at("ttfboxd.yaml"), ready=self.at("http"))
        self.wait(lambda: "listening at=\"127" in self.log("daemon"), "it does not listen to this machine")
        self.tcp = re.findall('listening at="(127[^"]*)"', self.log("daemon"))[-1]

    def token(self):
        with open(os.path.join(self.data, ".ttfbox", "token"), encoding="ascii") as file:
            return file.read().strip()

    def cable(self):
        self.start("cable", self.cable_program, self.at("cable"), str(self.random.randrange(1, 1 << 40)),
                   ready=self.at("cable.control"))
        self.control = socket.socket(socket.AF_UNIX)
        self.control.connect(self.at("cable.control"))

    def box(self):
        """usbd, and its worker's process id later by worker()."""
        self.start("usbd", self.usbd, "--cable", self.at("cable"), "--server", self.at("http"))
        self.wait(lambda: "ready at" in self.log("usbd"), "usbd is not ready")

    def worker(self):
        pid = self.processes["usbd"].pid
        with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as file:
            children = file.read().split()
        return int(children[0]) if children else None

    def bridge(self):
        if os.path.exists(self.at("pc")):
            os.unlink(self.at("pc"))
        self.start("bridge", self.ttfbox, "usb", "--box", "cable:" + self.at("cable"), "--listen", "unix:" + self.at("pc"),
                   ready=self.at("pc"))

    def all(self):
        self.serve()
        self.cable()
        self.box()
        self.bridge()

    def tell(self, command):
        """The cable."""
        self.control.sendall(command.encode() + b"\n")
        if self.control.recv(16) != b"ok\n":
            raise Failed(f"the cable does not know '{command}'")

    # ---- data

    def dataset(self, slots=5, width=96, height=64):
        """One of so small pictures, captured; its folder."""
        plan = self.at("plan.yaml")
        with open(plan, "w", encoding="ascii") as file:
            file.write("interval: 2min\ncount: %d\nlamps: {mode: continuous}\nshots:\n  - {stream: main, channel: white, "
                       "lamps: {left: 100%%, right: 100%%}, exposure: 20ms}\nkeep: both\nmains: 50Hz\n" % slots)
        folder = os.path.join(self.data, "grass")
        subprocess.run([self.ttfbox, "capture", plan, "--board", "sim-small", "--set", f"sim.sensor.width={width}px",
                        "--set", f"sim.sensor.height={height}px", "-o", folder], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        return folder

    def file(self, name, size, pattern=None):
        """A file of the dataset 'grass', and its path by HTTP."""
        data = self.random.randbytes(min(size, 1 << 20)) if pattern is None else pattern
        with open(os.path.join(self.data, "grass", name), "wb") as file:
            left = size
            while left > 0:
                file.write(data[:left])
                left -= min(left, len(data))
        return "/api/v1/datasets/grass/files/" + name

    # ---- clients

    def connect(self, timeout=30, direct=False):
        return UnixConnection(self.at("http" if direct else "pc"), timeout)

    def get(self, path, connection=None, headers=None, method="GET", body=None):
        c = connection or self.connect()
        c.request(method, path, body, headers=headers or {})
        answer = c.getresponse()
        body = answer.read()
        if not connection:
            c.close()
        return answer.status, body

    def is_healthy(self, seconds):
        """The status, asked by a new client, right within so many seconds; how many it took."""
        begun = time.monotonic()
        c = self.connect(timeout=seconds)
        try:
            status, body = self.get(HEALTH, c)
        except (OSError, http.client.HTTPException) as error:
            raise Failed(f"no status after {time.monotonic() - begun:.3f} s: {error}\n{self.log('bridge')}\n"
                         f"{self.log('usbd')}") from error
        finally:
            c.close()
        if status != 200 or not body.startswith(b'{"ok":true'):
            raise Failed(f"the status is {status}, {body[:200]!r}")
        return time.monotonic() - begun


def say(text):
    print(text, flush=True)


def quantiles(values):
    values = sorted(values)
    return {"p50": values[len(values) // 2], "p99": values[min(len(values) - 1, int(len(values) * 0.99))], "max": values[-1]}


def digest(folder):
    """Of all files below, by name."""
    sums = {}
    for base, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(base, name)
            with open(path, "rb") as file:
                sums[os.path.relpath(path, folder)] = hashlib.sha256(file.read()).hexdigest()
    return sums
