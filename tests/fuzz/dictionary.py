#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the fuzzer's dictionary of one target: words that no mutation would guess.

    dictionary.py TARGET

Keys and values come from the sources that read them, tags by their numbers from libtiff's header, so
that a new key is in the dictionary at once.
"""
import glob
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LINES = ["dataset/record_read.c", "dataset/record_write.c", "dataset/record.c", "dataset/lines.c",
         "dataset/verify_records.c", "dataset/writer_learn.c"]
SOURCES = {
    "plan": ["firmware/config/plan_file.c", "firmware/config/lamp_levels.c", "firmware/config/units.c"],
    "board": ["firmware/config/board_*.c", "firmware/config/registry.c", "firmware/config/units.c"],
    "manifest": ["dataset/manifest*.c", "dataset/pixbuf.c"],
    "records": LINES, "events": LINES, "store": LINES,
    "sums": ["dataset/sums.c", "dataset/walk.c", "dataset/verify_sums.c"],
    "calibration": ["dataset/calibration_load.c", "dataset/calibration_store.c"],
    "map": ["synth/quilt/map_file.c"],
    "request": ["firmware/http/access.c"],
    "body": ["firmware/http/body.c", "firmware/http/session.c", "firmware/http/newest.c"],
    "settings": ["firmware/config/daemon_file.c", "firmware/config/alerts_file.c", "firmware/config/units.c"],
    "orders": ["firmware/daemon/orders_file.c"], "preview": ["firmware/preview/cache.c"],
    "pull": LINES + ["firmware/pull/seal.c", "firmware/pull/lines.c"],
    "tiff": ["dataset/tiff_*.c"], "dng": ["dataset/tiff_*.c", "dataset/dng_*.c"],
}
OTHER = {
    "png": [b"IHDR", b"PLTE", b"IDAT", b"IEND", b"tRNS", b"gAMA", b"cHRM", b"sRGB", b"iCCP", b"eXIf",
            b"tEXt", b"zTXt", b"iTXt", b"sBIT", b"bKGD", b"pHYs", b"tIME"],
    "jpeg": [b"Exif\0\0", b"JFIF\0", b"ICC_PROFILE\0", b"Adobe", b"II*\0\x08\0\0\0", b"MM\0*\0\0\0\x08",
             b"2020:05:28 18:20:01\0"] + [b"\xff" + bytes([m]) for m in (
                 0xc0, 0xc1, 0xc2, 0xc3, 0xc4, 0xd8, 0xd9, 0xda, 0xdb, 0xdd, 0xe0, 0xe1, 0xe2, 0xee)],
    "sums": [b"records.jsonl", b"frames/main/000000.tif", b"0" * 64 + b"  "],
    "pull": [b"records.jsonl", b"frames/main/000000.tif", b"plans/0.yaml", b"../", b"0" * 64 + b"  "],
    "conditions": [b'W/"', b'"5f3c-1a"', b"~-1", b"~-3", b"~-4"],
    "lampd": [b"TLD3"] + [b"TLD3" + bytes([op, 0, 0, 0]) for op in range(1, 10)],
    "request": [b"bytes=", b"Bearer ", b"/api/v1/datasets/", b"/files/", b"/records", b"/tar", b"../", b"[::1]:"],
    # Heads of frames: stream 1, each type, the usual lengths.
    "usb": [b"\x01\0" + bytes([t]) + b"\0" + bytes([n]) + b"\0\0\0" for t in range(2, 6) for n in (0, 4, 16)] +
           [b"\0\0\x01\0\x10\0\0\0\x01\0\x20\0\0\0\x04\0", b"\0\0\x06\0\0\0\0\0", b"\x4d\0\0\0\0\0\0\0"],
    "mdns": [b"\x0bttfbox-0007\x05local\0", b"\xc0\x0c", b"\0\x01\0\x01", b"\0\x01\x80\x01", b"\0\x1c\0\x01", b"\0\xff\0\x01",
             b"\0\0\0\x78\0\x04\x0a\x3c\x07\x01"],
    "store": [b"frames/main/", b".tmp", b"\0"], "records": [b"frames/main/"],
}
EXIF = [0x0112, 0x0132, 0x8769, 0x9003, 0x9004, 0x9011, 0x9291, 0x882a]


def sources(target):
    for pattern in SOURCES.get(target, []):
        for path in sorted(glob.glob(os.path.join(ROOT, pattern))):
            with open(path, encoding="utf-8") as f:
                yield "".join(line for line in f if not line.startswith("#include"))


def words(target):
    """Literals that can be keys or values; in JSON also with their quotes."""
    found = set()
    for text in sources(target):
        for literal in re.findall(r'"((?:[^"\\]|\\.)*)"', text):
            if re.fullmatch(r"[A-Za-z][A-Za-z0-9_.-]{1,23}", literal):
                found.add(literal.encode())
    if target not in ("plan", "board", "sums", "tiff", "dng"):
        found |= {b'"' + w + b'":' for w in found} | {b'"' + w + b'"' for w in found}
    if target in ("plan", "board"):
        found |= {w + b": " for w in found}
    return found


def tags(target):
    """The tags that the sources name, as both byte orders write them."""
    header = glob.glob("/usr/include/tiff.h") + glob.glob("/usr/include/*/tiff.h")
    with open(header[0], encoding="utf-8") as f:
        known = dict(re.findall(r"#define\s+((?:TIFF|EXIF)TAG_\w+)\s+(\d+)", f.read()))
    named = {n for text in sources(target) for n in re.findall(r"(?:TIFF|EXIF)TAG_\w+", text)}
    # Numbers beyond 16 bits are libtiff's own, of no file.
    numbers = {int(known[n]) for n in named if n in known and int(known[n]) < 65536}
    return {n.to_bytes(2, order) for n in numbers for order in ("little", "big")}


def main():
    target = sys.argv[1]
    found = words(target) | set(OTHER.get(target, []))
    if target in ("tiff", "dng"):
        found |= tags(target)
    if target in ("png", "jpeg"):
        found |= {n.to_bytes(2, order) for n in EXIF for order in ("little", "big")}
    for word in sorted(found):
        print('"%s"' % "".join(chr(b) if 32 < b < 127 and chr(b) not in '"\\' else "\\x%02x" % b
                               for b in word))


if __name__ == "__main__":
    main()
