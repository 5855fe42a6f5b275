#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes datasets by hand, from dataset/FORMAT.md alone: an independent writer.

    make.py FOLDER     makes FOLDER/bracket, FOLDER/two-channels, ...

Its output is the same every time. It shares no code with the project, so that a
mistake of the writer in C and one of the reader cannot cancel out.
"""
import datetime
import hashlib
import json
import os
import struct
import sys
import zlib

SECOND = 1_000_000_000
UTC0 = 1_790_000_000 * SECOND
BOOT = ["0a0b0c0d-0000-4000-8000-00000000000%d" % i for i in range(4)]


def linear_profile():
    """An ICC profile of straight tone curves (ICC.1:2010), with the little that its readers need."""
    xyz = [(0.4360, 0.2225, 0.0139), (0.3851, 0.7169, 0.0971), (0.1431, 0.0606, 0.7141)]
    white = (0.9642, 1.0, 0.8249)
    straight = b"curv" + bytes(8)
    tags = [(n + b"TRC", straight) for n in (b"r", b"g", b"b")]
    tags += [(n, b"XYZ " + bytes(4) + struct.pack(">3i", *(round(v * 65536) for v in value)))
             for n, value in zip((b"rXYZ", b"gXYZ", b"bXYZ", b"wtpt"), (*xyz, white))]
    at, table, data = 128 + 4 + 12 * len(tags), struct.pack(">I", len(tags)), b""
    for name, value in tags:
        table += struct.pack(">4sII", name, at + len(data), len(value))
        data += value
    head = struct.pack(">I4sI4s4s4s", at + len(data), bytes(4), 0x04300000, b"mntr", b"RGB ", b"XYZ ")
    head += struct.pack(">6H", 2026, 1, 1, 0, 0, 0) + b"acsp" + bytes(28)
    head += struct.pack(">3i", *(round(v * 65536) for v in white))
    return head.ljust(128, b"\0") + table + data


def exif(at, start_utc_ns, exposure_ns, zone_s):
    """An Exif folder that lies at `at`: the start in local time, and how long it was exposed."""
    local = datetime.datetime(1970, 1, 1) + datetime.timedelta(
        seconds=start_utc_ns // SECOND + zone_s)
    zone = "%s%02d:%02d" % ("-" if zone_s < 0 else "+", abs(zone_s) // 3600, abs(zone_s) // 60 % 60)
    values = [(33434, 5, 1, struct.pack("<II", exposure_ns, SECOND)),
              (36867, 2, 20, local.strftime("%Y:%m:%d %H:%M:%S").encode() + b"\0"),
              (36881, 2, 7, zone.encode() + b"\0"),
              (37521, 2, 10, b"%09d\0" % (start_utc_ns % SECOND))]
    out, data = struct.pack("<H", len(values)), b""
    behind = at + 2 + 12 * len(values) + 4
    for tag, kind, count, value in values:
        out += struct.pack("<HHII", tag, kind, count, behind + len(data))
        data += value + bytes(len(value) % 2)
    return out + struct.pack("<I", 0) + data


def tiff(width, height, samples, codes, taken=None):
    """A 16-bit linear TIFF of one strip; codes is a flat list. taken: start, exposure and zone, and then a profile, too."""
    data = struct.pack("<%dH" % len(codes), *codes)
    bits = struct.pack("<%dH" % samples, *[16] * samples)
    entries = [
        (256, 3, 1, width), (257, 3, 1, height), (258, 3, samples, None), (259, 3, 1, 1),
        (262, 3, 1, 2 if samples == 3 else 1), (273, 4, 1, None), (274, 3, 1, 1),
        (277, 3, 1, samples), (278, 3, 1, height), (279, 4, 1, len(data)), (284, 3, 1, 1),
    ]
    profile = linear_profile() if taken else b""
    if taken:
        entries += [(34665, 4, 1, None), (34675, 7, len(profile), None)]
    bits_at = 8 + 2 + 12 * len(entries) + 4
    profile_at = bits_at + len(bits)
    exif_at = profile_at + len(profile)
    behind = profile + (exif(exif_at, *taken) if taken else b"")
    data_at = profile_at + len(behind)
    out = struct.pack("<2sHIH", b"II", 42, 8, len(entries))
    for tag, kind, count, value in entries:
        if tag == 258:
            value = bits_at if samples > 2 else 16
        if tag == 273:
            value = data_at
        if tag in (34665, 34675):
            value = exif_at if tag == 34665 else profile_at
        out += struct.pack("<HHI", tag, kind, count)
        out += struct.pack("<HH" if kind == 3 and count == 1 else "<I",
                           *((value, 0) if kind == 3 and count == 1 else (value,)))
    return out + struct.pack("<I", 0) + bits + behind + data


class Dataset:
    def __init__(self, folder, name, streams, minor=1, required=(), major=1, **more):
        self.path = os.path.join(folder, name)
        os.makedirs(self.path)
        self.seq = {"records.jsonl": 0, "events.jsonl": 0}
        self.streams = streams
        self.counts = {}
        self.put("events.jsonl", b"")
        self.put("records.jsonl", b"")
        root = {
            "format": {"name": "ttf", "major": major, "minor": minor, "required": list(required),
                       "optional": []},
            "uuid": "f00dcafe-0000-4000-8000-%012x" % zlib.crc32(name.encode()),
            "title": "hand-made: " + name, "simulated": False, "software": "make.py",
            "streams": streams,
        }
        root.update(more)
        self.minor = minor
        self.put("dataset.json", (json.dumps(root, indent=2) + "\n").encode())

    def put(self, path, data):
        full = os.path.join(self.path, path)
        os.makedirs(os.path.dirname(full), exist_ok=True)
        with open(full, "wb") as f:
            f.write(data)
        return {"path": path, "bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}

    def line(self, kind, file="records.jsonl", /, **fields):
        body = {"type": kind, "seq": self.seq[file]}
        body.update(fields)
        text = json.dumps(body, separators=(",", ":"))[:-1].encode()
        self.seq[file] += 1
        with open(os.path.join(self.path, file), "ab") as f:
            f.write(text + b',"crc":"%08x"}\n' % zlib.crc32(text))

    def plan(self, n, text):
        self.line("plan", plan=n, files=[self.put("plans/%d.yaml" % n, text.encode())])

    def segment(self, n, first=0, utc=UTC0, trust="rtc", interval=10 * SECOND, **more):
        fields = {"segment": n, "first_index": first, "boot_id": BOOT[n],
                  "origin_ns": 5 * SECOND}
        if utc is not None:
            fields.update(origin_utc_ns=utc, uncertainty_ns=SECOND)
        if self.minor > 0:  # since 1.1
            with open(os.path.join(self.path, "dataset.json"), "rb") as f:
                more["dataset_sha256"] = hashlib.sha256(f.read()).hexdigest()
        self.line("segment", **fields, trust=trust, interval_ns=interval, zone="UTC",
                  zone_offset_s=0, **more)

    def calibration(self, name):
        self.line("calibration", id=name, files=[
            self.put("calibration/%s/calibration.json" % name,
                     ('{"id":"%s"}\n' % name).encode())])

    def image(self, stream, index, suffix="", level=0, taken=None, **more):
        s = next(s for s in self.streams if s["id"] == stream)
        n = s["width"] * s["height"] * s["samples"]
        codes = [2047 + 100 * index + level + i for i in range(n)]
        file = {"role": "developed"}
        file.update(self.put("frames/%s/%06d%s.tif" % (stream, index, suffix),
                             tiff(s["width"], s["height"], s["samples"], codes, taken)))
        image = {"stream": stream}
        image.update(more)
        image.setdefault("n_averaged", 1)
        image["files"] = [file]
        image["mean_level"] = (sum(codes) / n - 2047) / 31744
        return image

    def slot(self, index, images, segment=0, first=0, result="captured", **more):
        self.counts[result] = self.counts.get(result, 0) + 1
        due = 5 * SECOND + (index - first) * 10 * SECOND
        fields = {"index": index, "segment": segment, "due_ns": due}
        if result == "captured":
            fields["middle_ns"] = due + 250_000
        fields["result"] = result
        fields.update(more)
        if images:
            fields["images"] = images
        self.line("slot", **fields)

    def end(self, reason="count"):
        self.line("end", reason=reason, slots=sum(self.counts.values()), **self.counts)

    def seal(self):
        listed = []
        for folder, folders, files in os.walk(self.path):
            if folder == self.path and "preview" in folders:
                folders.remove("preview")
            for name in files:
                path = os.path.relpath(os.path.join(folder, name), self.path)
                if path not in ("SHA256SUMS", "notes.jsonl", "samples.json", "report.json"):
                    listed.append(path)
        out = ""
        for path in sorted(listed, key=lambda p: p.encode()):
            with open(os.path.join(self.path, path), "rb") as f:
                out += "%s  %s\n" % (hashlib.sha256(f.read()).hexdigest(), path)
        self.put("SHA256SUMS", out.encode())


def stream(name="main", primary=True, **more):
    s = {"id": name, "quantity": "reflectance", "unit": "1", "width": 4, "height": 3, "samples": 3,
         "sample_format": "u16", "encoding": {"pedestal": 2047, "scale": 31744},
         "colour_space": "linear-srgb"}
    s.update(more)
    if primary:
        s["primary"] = True
    return s


def example(folder):
    d = Dataset(folder, "example", [stream(mm_per_px=0.05)])
    d.plan(0, "interval: 10s\ncount: 1\n")
    d.segment(0, plan=0)
    asked = {"exposure_ns": 10_000_000, "gain_milli": 1000}
    d.slot(0, [d.image("main", 0, shots=[
        {"asked": asked, "granted": asked, "start_ns": 4_995_250_000, "end_ns": 5_005_250_000,
         "lamps": [{"name": "left", "commanded_permille": 1000, "measured_permille": 996}]}])],
        sensors=[{"name": "box", "kind": "temp_mdegc", "ok": True, "value": 21500}])
    d.end()
    d.seal()


def bracket(folder):
    d = Dataset(folder, "bracket", [stream()])
    d.segment(0)
    for i in range(3):
        d.slot(i, [d.image("main", i, ".b%d" % b, level=1000 * b,
                           bracket={"index": b, "relative_exposure": e})
                   for b, e in enumerate((0.25, 1, 4))])
    d.end()
    d.seal()


def two_channels(folder):
    d = Dataset(folder, "two-channels",
                [stream("white", channel="white"),
                 stream("raking", False, channel="raking-left")],
                channels=[{"id": "white"}, {"id": "raking-left", "title": "from the left"}])
    d.segment(0)
    for i in range(3):
        d.slot(i, [d.image("white", i), d.image("raking", i, level=500)])
    d.slot(3, [d.image("white", 3), {"stream": "raking", "lacking": "lamp tripped"}],
           result="partial", reason="lamp left tripped")
    d.end()
    d.seal()


def two_cameras(folder):
    d = Dataset(folder, "two-cameras",
                [stream("top", camera="top"),
                 stream("side", False, camera="side", width=2, height=2)],
                cameras=[{"id": "top", "model": "A", "raw_width": 8, "raw_height": 6,
                          "cfa": "RGGB", "raw_bits": 12}, {"id": "side"}],
                group={"uuid": "f00dcafe-0000-4000-8000-000000000099", "member": "both"})
    d.segment(0)
    for i in range(2):
        d.slot(i, [d.image("top", i), d.image("side", i)])
    d.end("until")
    d.seal()


def average(folder):
    d = Dataset(folder, "average-of-8", [stream()])
    d.segment(0)
    for i in range(2):
        asked = {"exposure_ns": 10_000_000, "gain_milli": 1000, "wb_r_milli": 1000,
                 "wb_b_milli": 1000, "lens_mdpt": 3000}
        shots = []
        for k in range(9):
            at = (5 + 10 * i) * SECOND + k * 40_000_000
            shots.append({"asked": asked, "granted": asked, "start_ns": at,
                          "end_ns": at + 10_000_000})
        shots[4]["refused"] = "corrupt"
        taken = UTC0 + 10 * i * SECOND, 10_000_000, (7200, -12600)[i]
        d.slot(i, [d.image("main", i, shots=shots, n_averaged=8, taken=taken)])
    d.end()
    d.seal()


def three_segments(folder):
    """A box that twice lost power: once with a clock, once without; UTC came later. Unsealed, and of a writer of format 1.0."""
    d = Dataset(folder, "three-segments", [stream()], minor=0)
    d.plan(0, "interval: 10s\ncount: 9\n")
    d.segment(0, plan=0)
    for i in range(3):
        d.slot(i, [d.image("main", i)])
    d.segment(1, first=5, utc=UTC0 + 50 * SECOND, plan=0, gap_ns=20 * SECOND)
    for i in (3, 4):
        d.slot(i, [], result="power", reason="the box had no power")
    d.slot(5, [d.image("main", 5)], segment=1, first=5)
    d.segment(2, first=6, utc=None, trust="none", plan=0, gap_ns=None)
    d.slot(6, [d.image("main", 6)], segment=2, first=6)
    d.slot(7, [], segment=2, first=6, result="missed", reason="storage too slow")
    d.segment(2, first=6, utc=UTC0 + 3660 * SECOND, trust="ntp", plan=0, corrects=True,
              gap_ns=3590 * SECOND)
    d.slot(8, [d.image("main", 8)], segment=2, first=6)
    d.line("event", "events.jsonl", kind="resume", at_ns=4 * SECOND, text="after 20 s")
    with open(os.path.join(d.path, "records.jsonl"), "rb") as f:
        lines = [json.loads(l) for l in f]
    d.put("SHA256SUMS", "".join(
        "%s  %s\n" % (file["sha256"], file["path"]) for l in lines if l["type"] == "slot"
        for image in l.get("images", []) for file in image["files"]).encode())


def gone_on_with(folder):
    """In a second storage, after 20 s of outages for which no slot stands; when slot 0 was is by a PC's word."""
    d = Dataset(folder, "gone-on-with", [stream()],
                group={"uuid": "f00dcafe-0000-4000-8000-000000000098", "member": "second"})
    d.plan(0, "interval: 10s\ncount: 5\n")
    d.segment(0, first=3, utc=UTC0 + 50 * SECOND, trust="ntp", plan=0, run_ns=30 * SECOND,
              run_utc_ns=UTC0, run_trust="host", run_gaps_ns=0, run_doubted_ns=10 * SECOND)
    for i in (3, 4):
        d.slot(i, [d.image("main", i)], first=3)
    d.end()
    d.seal()


def changed_calibration(folder):
    d = Dataset(folder, "changed-calibration", [stream()])
    d.segment(0)
    d.calibration("cal-a")
    for i in range(4):
        if i == 2:
            d.calibration("cal-b")
        d.slot(i, [d.image("main", i, calibration="cal-a" if i < 2 else "cal-b")])
    d.end()
    d.seal()


def sagging_supply(folder):
    """Whoever reads images alone finds what the slot's sensor says at each of them."""
    d = Dataset(folder, "sagging-supply", [stream()])
    d.segment(0)
    for i in range(3):
        d.slot(i, [d.image("main", i, flags=["late", "under-voltage"])] if i == 1 else [d.image("main", i)],
               sensors=[{"name": "supply", "kind": "undervoltage", "ok": True, "value": int(i == 1)}])
    d.end()
    d.seal()


def future(folder):
    """Of a later minor version, full of what 1.0 does not know."""
    d = Dataset(folder, "future-minor", [
        stream(polarisation={"angles": [0, 45, 90]}),
        stream("spectrum", False, sample_format="u32", samples=31)], minor=7,
        optional_things={"weather": True})
    with open(os.path.join(d.path, "dataset.json")) as f:
        root = json.load(f)
    root["format"]["optional"] = ["polarisation"]
    d.put("dataset.json", json.dumps(root).encode())
    d.line("weather", outside={"rain": [1, 2]}, files="none of your business")
    d.segment(0, leap_seconds="smeared")
    d.put("orbits/1.txt", b"unknown file\n")
    for i in range(2):
        image = d.image("main", i, phase_of_moon=0.25, flags=["moonlit", "saturated"])
        extra = {"role": "stokes-vector-of-light", "compression": "magic"}
        extra.update(d.put("frames/main/%06d.stokes" % i, b"S" * (i + 1)))
        image["files"].insert(0, extra)
        d.slot(i, [image, {"stream": "spectrum", "files": [
            dict(d.put("frames/spectrum/%06d.bin" % i, b"u32"), role="developed")]}],
            mood={"of": "box"}, sensors=[
            {"name": "nose", "kind": "smell_milli", "ok": True, "value": 3, "unit": "milliolf"}])
        d.line("prediction", of=i + 1)
    d.line("event", "events.jsonl", kind="comet", at_ns=1, colour="green")
    d.line("gossip", "events.jsonl", about="the camera")
    d.end("the end of time")
    d.line("postscript", text="unknown lines may follow")
    d.put("notes.jsonl", b'{"utc_ns":1,"author":"me","slots":[[0,1]],"text":"!","tags":["odd"]}\n')
    d.put("preview/1.jpg", b"not a picture")
    d.seal()


def required(folder):
    d = Dataset(folder, "required-unknown", [stream()], minor=3, required=["time-travel"])
    d.segment(0)
    d.slot(0, [d.image("main", 0)])


def major_two(folder):
    d = Dataset(folder, "major-two", [stream()], major=2)
    d.segment(0)


def main():
    folder = sys.argv[1]
    os.makedirs(folder, exist_ok=True)
    for make in (example, bracket, two_channels, two_cameras, average, three_segments,
                 gone_on_with, changed_calibration, sagging_supply, future, required, major_two):
        make(folder)


if __name__ == "__main__":
    main()
