# SPDX-License-Identifier: Apache-2.0
"""The rig's machine: an emulated arm64 board with a real GPIO chip, looked at from outside."""
import json
import os
import re
import socket
import subprocess
import tempfile
import time

# The PL061 of qemu's virt machine: its data of all eight lines, and their direction (1 = output).
GPIO_DATA = 0x090303FC
GPIO_DIRECTION = 0x09030400
TRACE = re.compile(r"@(\d+\.\d+):pl061_set_output .*?setting output (\d+) to (\d+)")


class Machine:
    """Boots on entering, is killed on leaving."""

    ready_s = 120  # until its agent answers

    def __init__(self, rig, share, seconds=600, devices=()):
        self.rig, self.share, self.seconds, self.devices = rig, share, seconds, list(devices)
        self.folder = tempfile.mkdtemp(prefix="ttfbox-rig.")
        self.process = None

    def lent(self):
        """Where the guest finds its system and our programs: in the host's own folders."""
        return ["-fsdev", "local,id=t,path=%s/tree,security_model=none,readonly=on,multidevs=remap" % self.rig,
                "-device", "virtio-9p-pci,fsdev=t,mount_tag=tree",
                "-fsdev", "local,id=s,path=%s,security_model=none,multidevs=remap" % self.share,
                "-device", "virtio-9p-pci,fsdev=s,mount_tag=share"]

    def boots(self, words):
        """What it is, and what it boots."""
        return ["qemu-system-aarch64", "-accel", "tcg", "-M", "virt", "-cpu", "cortex-a53", "-m", "512",
                "-kernel", self.rig + "/kernel", "-initrd", self.rig + "/initramfs.gz",
                "-append", "console=ttyAMA0 quiet loglevel=4 panic=-1" + words] + self.lent()

    def __enter__(self):
        self.power_on()
        return self

    def power_on(self, words=""):
        f = self.folder
        command = ["timeout", "-k", "5", str(self.seconds)] + self.boots(words) + [
            "-smp", "1", "-nodefaults", "-no-reboot", "-display", "none", "-serial", "file:" + f + "/serial",
            "-device", "virtio-serial-pci", "-chardev", "socket,id=a,path=%s/agent,server=on,wait=off" % f,
            "-device", "virtconsole,chardev=a",
            "-chardev", "socket,id=p,path=%s/port,server=on,wait=off" % f, "-device", "virtconsole,chardev=p", "-qmp", "unix:%s/monitor,server=on,wait=off" % f,
            "-msg", "timestamp=on", "-d", "trace:pl061_set_output", "-D", f + "/trace"] + self.devices
        with open(f + "/qemu", "wb") as log:
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        try:
            self.meet()
        except Exception:
            self.__exit__()
            raise

    def meet(self):
        """The agent in the guest, and the emulator's own monitor."""
        self.agent = self.connect("agent")
        self.booted_s = float(self.until(b"AGENT-READY ", b"\n", self.ready_s))
        self.talk_to_monitor()

    def talk_to_monitor(self):
        self.monitor = self.connect("monitor").makefile("rw")
        self.monitor.readline()
        self.ask("qmp_capabilities")

    def __exit__(self, *_):
        if self.process and self.process.poll() is None:
            self.process.terminate()
            self.process.wait()
        subprocess.run(["rm", "-rf", self.folder], check=False)

    def cut(self):
        """Its power."""
        subprocess.run(["pkill", "-9", "-P", str(self.process.pid)], check=True)
        self.process.wait(10)

    def connect(self, name):
        end = time.monotonic() + 20
        while True:
            s = socket.socket(socket.AF_UNIX)
            try:
                s.connect(self.folder + "/" + name)
                return s
            except OSError:
                s.close()
                if time.monotonic() > end or self.process.poll() is not None:
                    raise RuntimeError("the machine does not start: " + self.log()) from None
                time.sleep(0.02)

    def log(self):
        text = ""
        for name in ("qemu", "serial"):
            try:
                with open(self.folder + "/" + name, errors="replace") as f:
                    text += f.read()[-1500:]
            except OSError:
                pass
        return text

    def until(self, mark, end, seconds):
        """What stands between mark and end; all before it is in self.heard."""
        data = b""
        stop = time.monotonic() + seconds
        while True:
            at = data.find(mark)
            to = data.find(end, at + len(mark)) if at >= 0 else -1
            if to >= 0:
                self.heard = data[:at].decode(errors="replace").replace("\r", "")
                return data[at + len(mark):to].decode()
            self.agent.settimeout(max(0.01, stop - time.monotonic()))
            try:
                more = self.agent.recv(65536)
            except socket.timeout:
                more = b""
            if not more:
                raise RuntimeError("no answer within %g s; heard %r; %s" % (seconds, data[-400:], self.log()))
            data += more

    def run(self, command, seconds=60):
        """In the guest: (exit code, output)."""
        self.begin(command.replace("\n", "; "))
        return self.end(seconds)

    def begin(self, command):
        """In the guest, without waiting for its end."""
        self.agent.sendall(command.encode() + b"\n")

    def end(self, seconds=60):
        """Of what began: (exit code, output)."""
        code = int(self.until(b"RC=", b"\n", seconds))
        return code, self.heard

    def begin_with_port(self, command):
        """The same; its standard input and output are the socket that is returned."""
        self.begin("exec 3<>/dev/hvc1; stty raw -echo <&3; %s <&3 >&3" % command)
        return self.connect("port")

    def word(self, address):
        """A word of the machine's memory, as nobody inside can colour it."""
        text = self.ask("human-monitor-command", **{"command-line": "xp /1wx 0x%x" % address})
        return int(text.split(":")[1], 16)

    def ask(self, command, **arguments):
        """Of the emulator itself."""
        self.monitor.write(json.dumps({"execute": command, "arguments": arguments}) + "\n")
        self.monitor.flush()
        while True:
            answer = json.loads(self.monitor.readline())
            if "return" in answer:
                return answer["return"]
            if "error" in answer:
                raise RuntimeError("%s: %s" % (command, answer["error"]))

    def lines(self):
        """Levels of the outputs, as {line: level}."""
        data, direction = self.word(GPIO_DATA), self.word(GPIO_DIRECTION)
        return {i: data >> i & 1 for i in range(8) if direction >> i & 1}

    def level(self, line, want, seconds=20):
        """Waits until a line has a level."""
        end = time.monotonic() + seconds
        while self.lines().get(line) != want:
            if time.monotonic() > end:
                return False
            time.sleep(0.002)
        return True

    def changes(self, since=0.0):
        """What the chip's outputs did, in order: (host's time, line, level)."""
        with open(self.folder + "/trace", errors="replace") as f:
            found = [(float(m[1]), int(m[2]), int(m[3])) for m in map(TRACE.search, f) if m]
        return [c for c in found if c[0] >= since]
