# SPDX-License-Identifier: Apache-2.0
"""What all measurements of synthesis share: children with their costs, places, inputs."""
import glob
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

PLAN = "boards/sim/plans/bench-synth.yaml"
ROOM = 6 << 30  # the largest section's outputs


def stop(why):
    sys.exit(f"bench synth: {why}")


def run(command, environment=None):
    """Costs of one child: wall, user and system seconds, peak resident bytes, and what it printed."""
    with tempfile.TemporaryFile() as out:
        begin = time.monotonic()
        child = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT,
                                 env=dict(os.environ, **(environment or {})))
        # wait4 and not Popen.wait: only it says what this one child took. The kernel counts what
        # this interpreter held at the fork too, so no peak is told that is less than some 15 MB.
        _, status, usage = os.wait4(child.pid, 0)
        wall = time.monotonic() - begin
        child.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        text = out.read().decode(errors="replace")
    if child.returncode != 0:
        stop(f"{' '.join(command[:12])}: status {child.returncode}\n{text[-2000:]}")
    return {"wall": wall, "user": usage.ru_utime, "sys": usage.ru_stime,
            "cpu": usage.ru_utime + usage.ru_stime, "peak_bytes": usage.ru_maxrss * 1024, "text": text}


def costs(done):
    return {name: done[name] for name in ("wall", "user", "sys", "cpu", "peak_bytes")}


def spread(values):
    return {"median": statistics.median(values), "least": min(values), "largest": max(values), "runs": values}


def load():
    return [round(x, 2) for x in os.getloadavg()]


def is_tmpfs(folder):
    with open("/proc/mounts", encoding="utf-8") as f:
        return any(line.split()[1] == folder and line.split()[2] == "tmpfs" for line in f)


class Bench:
    """The programs, a scratch folder in memory if there is one, and the inputs, made when first asked for."""

    def __init__(self, ttfbox, tests, plots, runs, grass):
        self.ttfbox, self.tests, self.plots, self.runs = ttfbox, tests, plots, runs
        self.data = os.environ.get("TTFBOX_TEST_DATA", "../shared/data")
        memory = "/dev/shm"
        self.in_memory = os.path.isdir(memory) and is_tmpfs(memory) and shutil.disk_usage(memory).free >= ROOM
        self.scratch = tempfile.mkdtemp(prefix="bench-synth-", dir=memory if self.in_memory else None)
        self.made = {"grass": grass} if grass else {}
        if not self.in_memory:
            print("there is no tmpfs with 6 GB free: files are written to a disk, and what it does is measured too")

    def close(self):
        shutil.rmtree(self.scratch, ignore_errors=True)

    def path(self, name):
        return os.path.join(self.scratch, name)

    def drop(self, name):
        path = self.path(name)
        if os.path.isdir(path):
            shutil.rmtree(path)
        elif os.path.exists(path):
            os.remove(path)

    def warm(self, n_bytes):
        """Memory that n_bytes of files in the scratch folder will lie in is the machine's already: a virtual machine may have
        given free pages back to its host, and whoever writes to them first pays several times what a page costs."""
        if not self.in_memory:
            return
        piece = bytes(1 << 20)
        with open(self.path("warm"), "wb", buffering=0) as f:
            for _ in range(n_bytes >> 20):
                f.write(piece)
        self.drop("warm")

    def quilt(self, dataset, *options):
        """One whole process, its costs and its report."""
        done = run([self.ttfbox, "synth", "quilt", dataset, "-q", "--json", *options])
        done["result"] = json.loads(done["text"].strip().splitlines()[-1])
        done["report"] = done["result"]["report"]
        return done

    def quilt_raw(self, dataset, *options, keep=False):
        """The same into one file of frames, which is taken away unless it is to be kept."""
        self.drop("out.raw")
        done = self.quilt(dataset, "--sink", "raw", "-o", self.path("out.raw"), *options)
        if not keep:
            self.drop("out.raw")
        return done

    def imported(self, name, pictures):
        path = self.path(name)
        run([self.ttfbox, "import", *pictures, "--interval", "1min", "-q", "-o", path])
        return path

    def real(self, name, first=0):
        """A dataset of a real sequence from its picture FIRST on; None, with a message, where it is absent."""
        key = f"{name}-{first}"
        if key not in self.made:
            pictures = sorted(glob.glob(os.path.join(self.data, "timelapse", name, "*.png")))[first:]
            self.made[key] = self.imported(key, pictures) if pictures else None
        if self.made[key] is None:
            print(f"{name}: skipped, it is not in {self.data} (TTFBOX_TEST_DATA)")
        return self.made[key]

    def grass(self):
        """The simulated capture: 500 frames of 256 x 256."""
        if "grass" not in self.made:
            run([self.ttfbox, "capture", PLAN, "--board", "sim-small", "-q", "-o", self.path("grass")])
            self.made["grass"] = self.path("grass")
        return self.made["grass"]

    def pictures_of_grass(self):
        """The frames of the capture as 8-bit PNGs."""
        if "pictures" not in self.made:
            run([self.ttfbox, "export", self.grass(), "--to", "png", "-q", "-o", self.path("pictures")])
            self.made["pictures"] = sorted(glob.glob(self.path("pictures/*.png")))
        return self.made["pictures"]

    def inputs(self):
        """(name, dataset) of copper without its first four frames (a jump of the light), clay, simulated grass."""
        found = [("copper 4-99", self.real("copper", 4)), ("clay", self.real("clay")),
                 ("grass, simulated", self.grass())]
        return [(name, path) for name, path in found if path]
