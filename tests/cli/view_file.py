#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads the file that `ttfbox view` makes, without our code.

usage: view_file.py FILE exact FOLDER     its pictures decode to the PNGs of FOLDER, byte by byte
       view_file.py FILE panels N         it has so many panels, each with the pictures that it says, and asks for nothing
       view_file.py FILE slots K...       its first panel shows these slots
       view_file.py noise FOLDER N W H    makes N pictures of noise
"""
import base64
import html.parser
import json
import random
import re
import struct
import sys
import zlib
from pathlib import Path


class Page(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.about, self.pictures, self.at, self.title = None, {}, None, ""
        self.policy, self.links = "", []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.links += [v for k, v in attrs.items() if k in ("src", "href", "srcset", "action", "data")]
        if attrs.get("http-equiv") == "Content-Security-Policy":
            self.policy = attrs["content"]
        self.at = ("about" if attrs.get("id") == "about" else attrs.get("class") if attrs.get("type") == "text/plain"
                   else tag if tag == "title" else None)

    def handle_data(self, data):
        if self.at == "about":
            self.about = json.loads(data)
        elif self.at == "title":
            self.title += data
        elif self.at:
            self.pictures.setdefault(self.at, []).append(base64.b64decode(data, validate=True))

    def handle_endtag(self, tag):
        self.at = None


def rgb_of_png(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        n, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + n]
        if kind == b"IHDR":
            w, h, depth, colour = struct.unpack(">IIBB", body[:10])
            assert (depth, colour) == (8, 2)
        elif kind == b"IDAT":
            packed += body
        at += 12 + n
    raw, rows, before = zlib.decompress(packed), [], bytes(w * 3)
    for y in range(h):
        kind, line = raw[y * (w * 3 + 1)], bytearray(raw[y * (w * 3 + 1) + 1:(y + 1) * (w * 3 + 1)])
        for i in range(w * 3):
            a, b, c = (line[i - 3] if i > 2 else 0), before[i], (before[i - 3] if i > 2 else 0)
            p = a + b - c
            near = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            line[i] = (line[i] + (0, a, b, (a + b) // 2, near)[kind]) & 255
        rows.append(bytes(line))
        before = rows[-1]
    return w, h, b"".join(rows)


def check(page):
    assert page.policy.startswith("default-src 'none'"), "it may ask for something"
    assert not page.links, f"it names {page.links}"
    for i, panel in enumerate(page.about["panels"]):
        got = page.pictures[f"p{i}"]
        assert len(got) == len(panel["slots"]) == len(panel["times_s"]), "not every frame is there"
        for data in got:
            head = b"\xff\xd8\xff" if panel["kind"] == "jpeg" else b"\x89PNG"
            assert data.startswith(head), "a picture is none"


def exact(page, folder):
    assert page.title == "</script><b>A & B", f"the title is {page.title!r}"
    panel = page.about["panels"][0]
    files = sorted(Path(folder).glob("*.png"))
    decode = [c / 255 / 12.92 if c <= 10 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in range(256)]
    worst = 0
    for file, data in zip(files, page.pictures["p0"], strict=True):
        w, h, want = rgb_of_png(file.read_bytes())
        assert (w, h) == (panel["width"], panel["height"])
        for a, b in zip(rgb_of_png(data)[2], want, strict=True):
            worst = max(worst, abs(decode[a] * panel["white"] - min(decode[b], panel["white"])) / (0.002 + decode[b]))
    assert worst < 0.04, f"values are off by a share of {worst:.3f}"


def noise(folder, n, w, h):
    source = random.Random(1)
    for k in range(n):
        raw = b"".join(b"\0" + source.randbytes(w * 3) for _ in range(h))
        chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        (Path(folder) / f"n{k:03}.png").write_bytes(
            b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", w, h, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(raw, 1)) + chunk(b"IEND", b""))


def main():
    if sys.argv[1] == "noise":
        return noise(sys.argv[2], *map(int, sys.argv[3:6]))
    text = Path(sys.argv[1]).read_text(encoding="utf-8")
    page = Page(text)
    check(page)
    assert not re.search(r"https?://(?!www\.w3\.org/2000/svg)", text), "it names a host"
    if sys.argv[2] == "exact":
        exact(page, sys.argv[3])
    elif sys.argv[2] == "panels":
        assert len(page.about["panels"]) == int(sys.argv[3])
    elif sys.argv[2] == "slots":
        assert page.about["panels"][0]["slots"] == list(map(int, sys.argv[3:])), page.about["panels"][0]["slots"]
    return 0


if __name__ == "__main__":
    sys.exit(main())
