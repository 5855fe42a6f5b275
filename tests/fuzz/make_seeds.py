#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the seeds of sums, events, store, usb, pull, lampd, conditions, orders, preview and mdns anew, into the folder given (tests/fuzz/seeds).

They speak of the small dataset of store.c: three slots of one file each. Lines have neither seq nor
crc of their own; the targets frame them (framing.h). The first byte is the mode of store.h.
"""
import hashlib
import os
import struct
import sys
import zlib

FRAME_RECORDS, FRAME_EVENTS, MEND_SUMS, ENDED = 1, 2, 4, 8
PICTURES = [("frames/main/%06d.tif" % i, b"picture %d\n" % i) for i in range(3)]
PLAN = ("plans/0.yaml", b"interval: 10s\ncount: 3\n")


def sha(data):
    return hashlib.sha256(data).hexdigest()


def entry(file, role=""):
    path, data = file
    return '{%s"path":"%s","bytes":%d,"sha256":"%s"}' % (role, path, len(data), sha(data))


def slot(i, segment=0, **more):
    return ('{"type":"slot","seq":0,"index":%d,"segment":%d,"due_ns":%d000000000,'
            '"result":"captured","images":[{"stream":"main","n_averaged":1,"files":[%s]}]'
            % (i, segment, 5 + 10 * i, entry(PICTURES[i], '"role":"developed",')))


SEGMENT = ('{"type":"segment","seq":0,"segment":%d,"first_index":%d,"origin_ns":5000000000,'
           '"trust":"%s","interval_ns":10000000000,"plan":0%s')
HEAD = ['{"type":"plan","seq":0,"plan":0,"files":[%s]' % entry(PLAN), SEGMENT % (0, 0, "none", "")]
SLOTS = [slot(i) for i in range(3)]
MISSED = ('{"type":"slot","seq":0,"index":%d,"segment":%d,"due_ns":%d,"result":"%s",'
          '"reason":"storage too slow"')
END = '{"type":"end","seq":0,"reason":"count","slots":3,"captured":3'
EVENT = '{"type":"event","seq":0,"kind":"door","at_ns":1,"at_utc_ns":1790000000000000000,"text":"opened"'
REPAIR = ('{"type":"event","seq":0,"kind":"repair","text":"set aside here",'
          '"detail":{"file":"records.jsonl","bytes":3,"hex":"7b2274"}')
SUMS = "".join("%s  %s\n" % (sha(data), path) for path, data in PICTURES)


def lines(*of):
    return "".join(line + "\n" for line in of)


def sealed(records):
    names = ["dataset.json", "events.jsonl", *[p for p, _ in PICTURES], "plans/0.yaml", "records.jsonl"]
    return "".join("0" * 64 + "  " + name + "\n" for name in names) if records else SUMS


FULL = lines(*HEAD, *SLOTS)
RICH = ('{"type":"slot","seq":0,"index":4,"segment":1,"due_ns":25000000000,"middle_ns":25000250000,'
        '"result":"partial","reason":"lamp tripped","sensors":[{"name":"box","kind":"temp_mdegc",'
        '"ok":true,"value":21500},{"name":"door","kind":"open","ok":false}],"images":[{"stream":"main",'
        '"bracket":{"index":0,"relative_exposure":0.25},"shots":[{"asked":{"exposure_ns":10000000,'
        '"gain_milli":1000,"wb_r_milli":1000,"wb_b_milli":1000,"lens_mdpt":3000},"granted":'
        '{"exposure_ns":10000000,"gain_milli":1000},"start_ns":1,"end_ns":2,"refused":"corrupt",'
        '"lamps":[{"name":"left","commanded_permille":1000,"measured_permille":996}]}],'
        '"lacking":"lamp tripped","flags":["saturated","lamp-tripped"],"mean_level":0.5,'
        '"reference_level":0.25,"sharpness":1.5}]')
RESUMED = lines(*HEAD, SLOTS[0], SEGMENT % (1, 1, "rtc", ',"origin_utc_ns":1790000000000000000,'
                '"uncertainty_ns":1000000000,"boot_id":"0a0b0c0d-0000-4000-8000-000000000001",'
                '"zone":"Europe/Berlin","zone_offset_s":7200,"gap_ns":null'),
                MISSED % (1, 1, 5, "missed"), MISSED % (2, 1, 15, "power"),
                SEGMENT % (1, 1, "ntp", ',"corrects":true,"gap_ns":3590000000000'), RICH)

SEEDS = {
    "sums": {
        "running": (0, SUMS), "behind": (0, SUMS[:81]), "torn": (0, SUMS[:120]),
        "ahead": (0, SUMS + sha(b"") + "  frames/main/000003.tif\n"),
        "other-order": (0, "".join(reversed(SUMS.splitlines(True)))),
        "sealed": (MEND_SUMS | ENDED, sealed(True)), "sealed-wrong": (ENDED, sealed(True)),
        "sealed-not-ended": (MEND_SUMS, sealed(True)),
    },
    "events": {
        "none": (FRAME_EVENTS, ""), "some": (FRAME_EVENTS, lines(EVENT, REPAIR, EVENT)),
        "no-newline": (FRAME_EVENTS, lines(EVENT) + EVENT),
        "fragment": (FRAME_EVENTS, lines(EVENT) + '~{"type":"event","se'),
        "damaged": (FRAME_EVENTS, lines(EVENT, "~" + EVENT, EVENT)),
        "two-without-newline": (FRAME_EVENTS, lines(EVENT) + EVENT + "\0" + EVENT),
    },
    "store": {
        "running": (7, FULL + "\0" + lines(EVENT) + "\0" + SUMS),
        "ended": (7, FULL + END + "\n" + "\0" + "\0" + SUMS),
        "sealed": (7, FULL + END + "\n" + "\0" + "\0" + sealed(True)),
        "resumed": (7, RESUMED + "\0" + lines(EVENT, REPAIR) + "\0" + SUMS[:88]),
        "no-newline": (7, FULL[:-1] + "\0" + EVENT + "\0" + SUMS),
        "fragment": (7, lines(*HEAD, *SLOTS[:2]) + "~" + SLOTS[2][:70] + "\0" + "\0" + SUMS[:176]),
        "uncommitted": (7, lines(*HEAD, *SLOTS[:2]) + "\0" + "\0" + SUMS[:176] +
                        "\0frames/main/000002.tif.tmp"),
        "two-uncommitted": (7, lines(*HEAD, SLOTS[0]) + "\0" + "\0" + SUMS[:88]),
        "stray": (7, FULL + "\0" + "\0" + SUMS + "\0frames/main/000001.mask.tif"),
        "calibration": (7, lines(*HEAD, '{"type":"calibration","seq":0,"id":"cal-a","files":[%s]'
                        % entry(PLAN), *SLOTS) + "\0" + "\0" + SUMS),
        "as-it-is": (0, "\0\0"),
    },
}


def usb_frame(stream, kind, payload=b""):
    return struct.pack("<HBBI", stream, kind, 0, len(payload)) + payload


def usb_take(*frames):
    """Of fuzz_usb.c: a transfer that comes."""
    data = b"".join(frames)
    return b"\0" + struct.pack("<H", len(data)) + data


HELLO = usb_frame(0, 1, struct.pack("<HHIQ", 1, 32, 256 << 10, 77))
GIVE, OPEN = b"\1", b"\2"
USB_SEEDS = {
    "box": b"\1" + usb_take(HELLO) + GIVE + GIVE +
           usb_take(usb_frame(1, 2), usb_frame(1, 3, b"GET / HTTP/1.1\r\n\r\n")) + b"\4\1\x40" + b"\3\1\x40" + GIVE +
           usb_take(usb_frame(1, 4, struct.pack("<I", 64)), usb_frame(1, 5, struct.pack("<I", 0))) + GIVE + b"\5\1\0" + GIVE,
    "host": b"\0" + GIVE + GIVE + usb_take(HELLO, usb_frame(0, 6, b"padding")) + OPEN + OPEN + b"\3\1\x20" + GIVE +
            usb_take(usb_frame(1, 3, b"HTTP/1.1 200 OK\r\n\r\n"), usb_frame(2, 5, struct.pack("<I", 2))) + b"\4\1\x40" + GIVE +
            usb_take(usb_frame(1, 5, struct.pack("<I", 1))) + GIVE,
    "anew": b"\0" + usb_take(HELLO) + OPEN + usb_take(usb_frame(0, 1, struct.pack("<HHIQ", 1, 32, 256 << 10, 0))) + b"\6" +
            usb_take(HELLO) + OPEN + GIVE,
    "stale": b"\1" + usb_take(usb_frame(1, 3, HELLO)) + usb_take(HELLO[8:]) + usb_take(HELLO, usb_frame(1, 2), usb_frame(2, 2)) + GIVE,
}


# Of fuzz_pull.c: how the box answers, then its answers.
WHOLE, BREAKS, MISSING, CORRECT, FRAMED = 1, 2, 4, 8, 16
SAME = b"picture 0\n"  # the content of every other file


def framed(line):
    """A record with the checksum of FORMAT.md: its bytes without the crc."""
    text = line[:-1] if line.endswith("}") else line
    return text + ',"crc":"%08x"}' % zlib.crc32(text.encode())


def pull_seed(how, records, names, summary='{"slots":1,"sealed":false}', sums=None, events="", notes=""):
    def file(path):
        return '{"role":"developed","path":"%s","bytes":%d,"sha256":"%s"}' % (path, len(SAME), sha(SAME))
    text = "".join((r if how & FRAMED else framed(r)) + "\n" for r in records(file))
    listed = "".join("%s  %s\n" % (sha(d), n) for n, d in sorted(names(text))) if sums is None else sums
    parts = ['{"format":"ttf","uuid":"0a0b0c0d-0000-4000-8000-000000000001"}', summary, text, events, notes, listed]
    return bytes([how]) + b"\0".join(p.encode() for p in parts) + b"\0" + SAME


def pull_records(file):
    return ['{"type":"plan","seq":0,"plan":0,"files":[%s]' % file("plans/0.yaml"),
            '{"type":"slot","seq":1,"index":0,"images":[{"stream":"main","files":[%s]}]' % file("frames/main/000000.tif"),
            '{"type":"slot","seq":2,"index":1,"images":[{"stream":"main","files":[%s]}]' % file("frames/main/000001.tif"),
            '{"type":"end","seq":3,"reason":"count"']


def pull_escape(file):
    return ['{"type":"slot","seq":0,"index":0,"images":[{"stream":"main","files":[%s]}]' % file("frames/../../../etc/passwd")]


def pull_names(records):
    return [("plans/0.yaml", SAME), ("frames/main/000000.tif", SAME), ("frames/main/000001.tif", SAME),
            ("records.jsonl", records.encode()), ("dataset.json", b'{"format":"ttf","uuid":"0a0b0c0d-0000-4000-8000-000000000001"}')]


PULL_SEEDS = {
    "framed": pull_seed(FRAMED | CORRECT, pull_records, pull_names, events=lines(EVENT)),
    "framed-growing": pull_seed(FRAMED, pull_records, pull_names, events=lines(EVENT, REPAIR)),
    "framed-breaks": pull_seed(FRAMED | BREAKS | CORRECT, pull_records, pull_names),
    "growing": pull_seed(MISSING, pull_records, pull_names),
    "sealed": pull_seed(CORRECT, pull_records, pull_names),
    "sealed-otherwise": pull_seed(0, pull_records, pull_names, '{"slots":2,"sealed":true,"digest":"%s"}' % ("0" * 64)),
    "seal-escapes": pull_seed(CORRECT, pull_records, pull_names, sums=sha(SAME) + "  ../../escaped\n"),
    "seal-hidden": pull_seed(CORRECT, pull_records, pull_names, sums=sha(SAME) + "  .ttf-anew\n"),
    "seal-empty": pull_seed(CORRECT, pull_records, pull_names, sums=""),
    "seal-otherwise": pull_seed(CORRECT, pull_records, lambda text: [(n, b"another" if n == "plans/0.yaml" else d)
                                                                     for n, d in pull_names(text)]),
    "breaks": pull_seed(BREAKS, pull_records, pull_names),
    "no-ranges": pull_seed(WHOLE | CORRECT, pull_records, pull_names),
    "escapes": pull_seed(0, pull_escape, pull_names),
    "notes": pull_seed(CORRECT, pull_records, pull_names, events=framed(EVENT) + "\n", notes='{"text":"mould"}\n'),
}


def lampd_step(client, ms, op, lamp=0, permille=0, flags=0, magic=0x33444C54, odd=1):
    """Of fuzz_lampd.c: a client, whether its message is whole, how long it waited, the message."""
    return struct.pack("<BBH", client, odd, ms) + struct.pack("<IHHIII", magic, op, flags, 7, lamp, permille)


LAMPD_SEEDS = {
    "lit": lampd_step(0, 0, 1) + lampd_step(0, 0, 2, 1) + lampd_step(0, 1, 3) + lampd_step(0, 1, 5, 0, 500) +
           lampd_step(0, 900, 4) + lampd_step(0, 60000, 6, 0) + lampd_step(0, 1, 7, 0) + lampd_step(0, 1, 8),
    "burnt": lampd_step(0, 0, 3) + lampd_step(0, 1, 5, 1, 1000) + b"".join(lampd_step(0, 400, 4) for _ in range(8)) +
             lampd_step(0, 1, 5, 1, 1000),
    "two": lampd_step(0, 0, 3) + lampd_step(1, 0, 3) + lampd_step(1, 0, 5, 0, 1000) + lampd_step(0, 0, 5, 0, 1000) +
           lampd_step(1, 0, 5, 0, 0) + lampd_step(1, 0, 9) + lampd_step(0, 0, 3, magic=1) + lampd_step(1, 5000, 5, 1, 1),
    "odd": lampd_step(0, 0, 99) + lampd_step(0, 0, 5, 77, 5000) + lampd_step(0, 0, 1, flags=1) + lampd_step(1, 0, 1, odd=6),
}

CONDITION_SEEDS = {
    "listed": b'"a", W/"5f3c-1a", "c"\n~-2', "star": b"*\n~-3", "none": b'"5f3c-1b"\n', "ahead": b"\n~-99",
    "other": b"5f3c-1a\n0123456789abcdef-1", "odd": b'""\n~-18446744073709551616',
}

ORDER_SEEDS = {
    "asked": b'{"state":"running","dataset":"grass","configuration":"plan.yaml into data/grass","plan":"first","plan_yaml":"interval: 10s\\ncount: 3\\n"}',
    "stopped": b'{"state":"stopped","dataset":"grass","configuration":"plan.yaml into data/grass","why":"its plan is wrong"}',
    "done": b'{"state":"done","dataset":"grass","configuration":"other.yaml"}',
    "done-here": b'{"state":"done","dataset":"grass","configuration":"plan.yaml into data/grass"}',
    "none": b'{"state":"none","dataset":"","configuration":"plan.yaml into data/grass"}', "half": b'{"state":"runn',
}

UUID = "0a0b0c0d-0000-4000-8000-000000000001"
PREVIEW_SEEDS = {
    "ready": ('{"state":"ready","dataset":"grass","uuid":"%s","generation":3,"images":6,"tried_images":6,"made_utc_ns":1,"width":8,'
              '"height":8,"shrunk_by":1,"frame_step":1,"frames":[{"path":"g3/000.jpg","slot":0}]}' % UUID).encode(),
    "failed": ('{"state":"failed","why":"no room","uuid":"%s","tried_images":7,"tries":4,"tried_utc_ns":9,"frames":[]}' % UUID).encode(),
    "other": b'{"state":"ready","uuid":"ffffffff-0000-4000-8000-000000000001","generation":1,"frames":[]}',
    "far": ('{"uuid":"%s","generation":2147483647,"tries":9223372036854775807,"tried_images":7}' % UUID).encode(),
    "odd": b'[1,2]',
}


def asks(kind, top=0, name=b"\x0bttfbox-0007\x05local\0", counts=(1, 0), behind=b""):
    """Of fuzz_mdns.c: a question."""
    return struct.pack(">HHHHHH", 7, 0, *counts, 0, 0) + name + struct.pack(">HH", kind, top | 1) + behind


MDNS_SEEDS = {
    "address": b"\0" + asks(1),
    "alone": b"\0" + asks(255, 0x8000),
    "six": b"\0" + asks(28),
    "plain": b"\1" + asks(1),
    "known": b"\0" + asks(1, counts=(1, 1), behind=b"\xc0\x0c" + struct.pack(">HHIHBBBB", 1, 1, 60, 4, 10, 60, 7, 1)),
    "pointer": b"\0" + asks(12, name=b"\5other\5local\0", counts=(2, 0), behind=b"\x0bttfbox-0007\xc0\x12" + struct.pack(">HH", 1, 1)),
    "itself": b"\0" + asks(1, name=b"\xc0\x0c"),
}


def main():
    for target, seeds in (("usb", USB_SEEDS), ("pull", PULL_SEEDS), ("lampd", LAMPD_SEEDS), ("conditions", CONDITION_SEEDS),
                          ("orders", ORDER_SEEDS), ("preview", PREVIEW_SEEDS), ("mdns", MDNS_SEEDS)):
        folder = os.path.join(sys.argv[1], target)
        os.makedirs(folder, exist_ok=True)
        for name, data in seeds.items():
            with open(os.path.join(folder, name), "wb") as f:
                f.write(data)
    for target, seeds in SEEDS.items():
        folder = os.path.join(sys.argv[1], target)
        os.makedirs(folder, exist_ok=True)
        for name, (mode, text) in seeds.items():
            with open(os.path.join(folder, name), "wb") as f:
                f.write(bytes([mode]) + text.encode())


if __name__ == "__main__":
    main()
