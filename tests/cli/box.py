#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
box.py URL TOKEN WORD...: what clients of a box do at once while it captures. Ends with 1 and a sentence where something is not so.
  watch N SECONDS   listens to events until N slots came, beginning where it is told again by Last-Event-ID; prints their indices
  crowd N SECONDS   N readers that ask for status and list, and one that pulls an archive without end; prints the slowest status
  deaf N            N listeners to events that never read, held until standard input ends
"""
import http.client
import json
import sys
import threading
import time
import urllib.parse

URL, TOKEN, WORD = sys.argv[1:4]
HOST = urllib.parse.urlsplit(URL)
HEAD = {"Authorization": "Bearer " + TOKEN}


def ask(path, timeout=10, headers=None):
    # From an address of its own: a hostile client may have used up its share.
    c = http.client.HTTPConnection(HOST.hostname, HOST.port, timeout=timeout, source_address=("127.0.0.99", 0))
    c.request("GET", HOST.path + path, headers={**HEAD, **(headers or {})})
    return c, c.getresponse()


def events(last, seconds):
    """Pairs of kind and data with their ids, from one connection."""
    headers = {"Last-Event-ID": last} if last else {}
    c, r = ask("/events", seconds, headers)
    assert r.status == 200, r.status
    assert r.getheader("Content-Type") == "text/event-stream"
    event, until = {}, time.monotonic() + seconds
    while time.monotonic() < until:
        line = r.readline().decode().rstrip("\n")
        if not line:
            if "event" in event:
                yield event["event"], json.loads(event["data"]), event.get("id")
            event = {}
        elif not line.startswith(":"):
            key, _, value = line.partition(": ")
            event[key] = value


def watch(n, seconds):
    """Cut off after every fifth slot and gone on with: none is lost, none comes twice; what lamps and sensors said comes with them."""
    seen, read, last = [], set(), None
    until = time.monotonic() + seconds
    while len(seen) < n:
        assert time.monotonic() < until, "only %d slots came: %r" % (len(seen), seen)
        for kind, data, ident in events(last, seconds):
            last = ident or last
            assert kind != "missed", "told that something was missed"
            if kind == "readings":
                assert [lamp["name"] for lamp in data["lamps"]] == ["left"], data
                assert [s["kind"] for s in data["sensors"]] == ["temp_mdegc"], data
                read.add(data["index"])
            if kind == "slot":
                seen.append(data["index"])
                if len(seen) % 5 == 0 or len(seen) == n:
                    break
    assert seen == list(range(seen[0], seen[0] + n)), seen
    assert len(read & set(seen)) > n / 2, "readings of %r alone" % sorted(read)
    print(" ".join(map(str, seen)))


def crowd(n, seconds):
    slowest, wrong, until = [0.0], [], time.monotonic() + seconds

    def reader(i):
        c = http.client.HTTPConnection(HOST.hostname, HOST.port, timeout=20, source_address=("127.0.0.%d" % (2 + i % 50), 0))
        while time.monotonic() < until:
            begun = time.monotonic()
            c.request("GET", HOST.path + ("/status" if i % 5 else "/datasets"), headers=HEAD)
            r = c.getresponse()
            r.read()
            if r.status != 200:
                wrong.append(r.status)
                return
            slowest[0] = max(slowest[0], time.monotonic() - begun)
            time.sleep(0.05)

    def puller():
        while time.monotonic() < until:
            c, r = ask("/datasets/first/tar", 20)
            while r.read(1 << 16):
                if time.monotonic() > until:
                    break
            c.close()

    threads = [threading.Thread(target=reader, args=(i,)) for i in range(n)] + [threading.Thread(target=puller)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert not wrong, "readers were refused: %r" % wrong[:5]
    print("%.0f ms" % (slowest[0] * 1000))


def deaf(n):
    held = [ask("/events", 60) for _ in range(n)]
    assert all(r.status == 200 for _, r in held)
    print("deaf", flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    {"watch": watch, "crowd": crowd, "deaf": deaf}[WORD](*map(int, sys.argv[4:]))
