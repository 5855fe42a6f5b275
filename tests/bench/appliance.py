#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A box that is used while it captures: ttfboxd on simulated devices in real time, 50 clients that read, one event
stream, one pull after the other at full speed; and cyclictest (rt-tests) in the same minutes, at the same interval and
under the same scheduling policy. Prints figures; exit 1 if a slot was missed, memory grew or p99 is more than
cyclictest's p99 and 5 ms. --untimed: without cyclictest, and times decide nothing (for a machine that does other things too).

usage: appliance.py TTFBOX TTFBOXD BOARD [--slots N] [--interval-ms MS] [--clients N] [--untimed]
"""
import argparse
import asyncio
import json
import os
import random
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

RSS_SLOT = 100
GROWTH_KB = 4096
TOKEN = "Authorization: Bearer of-this-campaign-alone\r\n"


def write(path, text):
    with open(path, "w", encoding="utf-8") as out:
        out.write(text)


def rss_kb(pid):
    with open(f"/proc/{pid}/status", encoding="utf-8") as status:
        return int(re.search(r"VmRSS:\s+(\d+)", status.read()).group(1))


def percentile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))] if values else float("nan")


def cyclic_percentile(text, share):
    counts = {int(m.group(1)): int(m.group(2)) for m in re.finditer(r"^(\d+)\s+(\d+)\s*$", text, re.M)}
    overflow = re.search(r"# Histogram Overflows: (\d+)", text)
    total, seen = sum(counts.values()) + (int(overflow.group(1)) if overflow else 0), 0
    for us in sorted(counts):
        seen += counts[us]
        if seen >= share * total:
            return us / 1000
    return float("inf")


class Seen:
    def __init__(self):
        self.answers, self.failures, self.latency_ms, self.slots = 0, 0, [], []
        self.over = False


async def ask(reader, writer, path, headers=""):
    writer.write(f"GET /api/v1{path} HTTP/1.1\r\nHost: localhost\r\n{TOKEN}{headers}\r\n".encode())
    head = await reader.readuntil(b"\r\n\r\n")
    length = re.search(rb"content-length: (\d+)", head, re.I)
    if length:
        await reader.readexactly(int(length.group(1)))
    return int(head.split()[1])


async def client(port, seen, n):
    chance = random.Random(n)
    paths = ["/status", "/datasets/run", "/datasets/run/charts", "/datasets", "/latest", "/health"]
    while not seen.over:
        try:
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            offset = 0
            while not seen.over:
                begun = time.monotonic()
                if chance.random() < 0.2:
                    status = await ask(reader, writer, "/datasets/run/records", f"Range: bytes={offset}-\r\n")
                else:
                    status = await ask(reader, writer, chance.choice(paths))
                seen.latency_ms.append((time.monotonic() - begun) * 1000)
                seen.answers += 1
                seen.failures += status not in (200, 206, 404, 416)
                await asyncio.sleep(chance.uniform(0.5, 1.5))
            writer.close()
        except (OSError, asyncio.IncompleteReadError):
            seen.failures += not seen.over
            await asyncio.sleep(0.5)


async def listen(port, seen):
    while not seen.over:
        try:
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(f"GET /api/v1/events HTTP/1.1\r\nHost: localhost\r\n{TOKEN}\r\n".encode())
            kind = ""
            while not seen.over:
                line = (await reader.readline()).decode()
                if not line:
                    break
                if line.startswith("event:"):
                    kind = line[6:].strip()
                if line.startswith("data:") and kind == "slot":
                    seen.slots.append(json.loads(line[5:]))
        except OSError:
            await asyncio.sleep(0.1)


async def pull(args, port, folder, seen, ret):
    while not seen.over:
        target = f"{folder}/pulled"
        begun = time.monotonic()
        child = await asyncio.create_subprocess_exec(
            args.ttfbox, "pull", target, "--box", f"http://127.0.0.1:{port}", "--only", "big", "-q", "--token-file", f"{folder}/token",
            stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.PIPE)
        _, said = await child.communicate()
        if child.returncode == 0:
            size = sum(os.path.getsize(os.path.join(path, name)) for path, _, names in os.walk(target) for name in names)
            ret.append(size / (time.monotonic() - begun) / 1e6)
        elif not seen.over:
            print("a pull failed:", said.decode().strip()[-200:], file=sys.stderr)
            await asyncio.sleep(1)
        shutil.rmtree(target, ignore_errors=True)


async def watch(args, daemon, seen, ret):
    while not seen.over:
        n = len(seen.slots)
        if n >= RSS_SLOT and "early" not in ret:
            ret["early"] = rss_kb(daemon.pid)
        if daemon.poll() is not None:
            seen.over = True
            sys.exit(f"ttfboxd ended with {daemon.returncode}")
        if n and seen.slots[-1]["index"] + 1 >= args.slots:
            ret["late"] = rss_kb(daemon.pid)
            seen.over = True
        await asyncio.sleep(0.2)


async def use(args, port, folder, daemon):
    seen, speeds, rss = Seen(), [], {}
    jobs = [listen(port, seen), pull(args, port, folder, seen, speeds), watch(args, daemon, seen, rss)]
    jobs += [client(port, seen, n) for n in range(args.clients)]
    await asyncio.wait_for(asyncio.gather(*jobs), args.slots * args.interval_ms / 1000 + 300)
    return seen, speeds, rss


def make_big(args, folder):
    write(f"{folder}/big.yaml", "interval: 10s\ncount: 60\nshot: {exposure: 10ms}\n")
    subprocess.run([args.ttfbox, "capture", f"{folder}/big.yaml", "--board", "sim-small", "--set", "sim.sensor.width=1024px",
                    "--set", "sim.sensor.height=768px", "-o", f"{folder}/data/big", "-q"], check=True, stdout=subprocess.DEVNULL)


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def wait_for(port):
    for _ in range(300):
        try:
            urllib.request.urlopen(f"http://127.0.0.1:{port}/api/v1/health", timeout=1).read()
            return
        except OSError:
            time.sleep(0.1)
    sys.exit("ttfboxd does not answer")


def run(args, folder):
    port = free_port()
    os.mkdir(f"{folder}/data")
    make_big(args, folder)
    write(f"{folder}/run.yaml", f"interval: {args.interval_ms}ms\ncount: {args.slots}\nshot: {{exposure: 10ms}}\nkeep: both\nreserve: 0B\n")
    write(f"{folder}/token", "of-this-campaign-alone\n")
    os.chmod(f"{folder}/token", 0o600)
    write(f"{folder}/ttfboxd.yaml", f"board: {os.path.abspath(args.board)}\nplan: run.yaml\ndata: data\ntoken_file: token\n"
                                    f"listen: ['127.0.0.1:{port}']\n"
                                    # a camera fast enough for five slots a second
                                    "set: {sim.timing.frame_period: 15ms, sim.timing.readout: 5ms, sim.timing.control_delay: 1, sim.timing.exposure_max: 50ms}\n")
    with open(f"{folder}/log", "w", encoding="utf-8") as log:
        daemon = subprocess.Popen([args.ttfboxd, "--config", f"{folder}/ttfboxd.yaml"], stderr=log, cwd=folder)
    try:
        wait_for(port)
        beside = None if args.untimed else subprocess.Popen(
            ["cyclictest", "-q", "--policy=other", "-t1", "-i", str(args.interval_ms * 1000), "-l", str(args.slots), "-h", "100000"],
            stdout=subprocess.PIPE, text=True)
        seen, speeds, rss = asyncio.run(use(args, port, folder, daemon))
        out = beside.communicate(timeout=120)[0] if beside else ""
        daemon.terminate()
        daemon.wait(60)
    except BaseException:
        with open(f"{folder}/log", encoding="utf-8") as log:
            print("".join(log.readlines()[-10:]), file=sys.stderr)
        raise
    finally:
        daemon.kill()
    return seen, speeds, rss, out


def not_captured(folder):
    """What the records say of slots that have no picture."""
    with open(f"{folder}/data/run/records.jsonl", encoding="utf-8") as records:
        slots = [json.loads(line) for line in records]
    return [(s["index"], s["result"], s.get("reason", "")) for s in slots if s.get("result", "captured") != "captured"]


def report(args, folder, seen, speeds, rss, cyclic):
    info = json.loads(subprocess.run([args.ttfbox, "info", f"{folder}/data/run", "--json"], capture_output=True, text=True,
                                     check=True).stdout.splitlines()[-1])
    verified = subprocess.run([args.ttfbox, "verify", f"{folder}/data/run", "-q"], stdout=subprocess.DEVNULL, check=False).returncode
    wakeup = [s["wakeup_ns"] / 1e6 for s in seen.slots if "wakeup_ns" in s]
    error = [abs(s["error_ns"]) / 1e6 for s in seen.slots if "error_ns" in s]
    c50, c99 = cyclic_percentile(cyclic, 0.5), cyclic_percentile(cyclic, 0.99)
    cmax = re.search(r"# Max Latencies: 0*(\d+)", cyclic)
    p99 = percentile(wakeup, 0.99)
    lost = args.slots - info["captured"] if "captured" in info else info["slots"] - info["results"]["captured"]
    print(f"slots {info['slots']} at {args.interval_ms} ms, {args.clients} clients, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    print(f"not captured: {lost}; verify: exit {verified}")
    for index, result, reason in not_captured(folder)[:20]:
        print(f"  slot {index} {result}: {reason}")
    print(f"wake-up: p50 {percentile(wakeup, 0.5):.3f} ms, p99 {p99:.3f} ms, max {max(wakeup, default=float('nan')):.3f} ms ({len(wakeup)} slots)")
    print(f"slot error: p50 {percentile(error, 0.5):.3f} ms, p99 {percentile(error, 0.99):.3f} ms, max {max(error, default=float('nan')):.3f} ms")
    if not args.untimed:
        print(f"cyclictest: p50 {c50:.3f} ms, p99 {c99:.3f} ms, max {int(cmax.group(1)) / 1000 if cmax else float('nan'):.3f} ms")
    print(f"answers {seen.answers}, failed {seen.failures}, p50 {percentile(seen.latency_ms, 0.5):.1f} ms, p99 {percentile(seen.latency_ms, 0.99):.1f} ms")
    print(f"pulls {len(speeds)}, median {percentile(speeds, 0.5):.0f} MB/s")
    print(f"VmRSS at slot {RSS_SLOT}: {rss.get('early')} kB, at the end: {rss.get('late')} kB")
    bad = []
    if lost or verified:
        bad.append("slots were lost")
    if not args.untimed and not p99 <= c99 + 5:
        bad.append("p99 is above cyclictest's and 5 ms")
    if rss.get("late", 0) - rss.get("early", 0) > GROWTH_KB:
        bad.append("memory grew")
    print("appliance:", "; ".join(bad) if bad else "holds")
    return 1 if bad else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("ttfbox")
    parser.add_argument("ttfboxd")
    parser.add_argument("board")
    parser.add_argument("--slots", type=int, default=3000)
    parser.add_argument("--interval-ms", type=int, default=200)
    parser.add_argument("--clients", type=int, default=50)
    parser.add_argument("--untimed", action="store_true")
    args = parser.parse_args()
    args.ttfbox, args.ttfboxd = os.path.abspath(args.ttfbox), os.path.abspath(args.ttfboxd)
    if not args.untimed and not shutil.which("cyclictest"):
        sys.exit("appliance: cyclictest is not installed (package rt-tests)")
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
        return report(args, folder, *run(args, folder))


if __name__ == "__main__":
    sys.exit(main())
