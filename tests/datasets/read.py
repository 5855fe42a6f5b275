#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads a dataset, from dataset/FORMAT.md alone: an independent reader.

    read.py DATASET      prints everything that is in it as one JSON object

Exit: 0, 3 if something is damaged, 1 if it is no dataset that this reader may read.
It shares no code with the project, so that two readers must agree on what the document says.
"""
import datetime
import hashlib
import json
import os
import re
import struct
import sys
import zlib
from fractions import Fraction

NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9._-]{0,63}")
HEX64 = re.compile(r"[0-9a-f]{64}")
UUID = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")
CRC_END = re.compile(rb',"crc":"([0-9a-f]{8})"\}')
SUM = re.compile(rb"([0-9a-f]{64})  (.+)")
RESULTS = ("captured", "partial", "missed", "failed", "paused", "power")
FORMATS = {"u8": "B", "u16": "H", "f16": "e", "f32": "f"}
SAMPLE_BITS = {"u8": 8, "u16": 16, "f16": 16, "f32": 32}
HOLE = "bytes that did not reach the disk"
PICTURES = ("developed", "uncertainty", "mask")  # roles
UNSEALED = ("SHA256SUMS", "notes.jsonl", "samples.json", "report.json")


class Refused(Exception):
    """No dataset, or one that must not be read."""


class Wrong(Exception):
    """A line or field is not as FORMAT.md has it."""


def is_int(v):
    return isinstance(v, int) and not isinstance(v, bool) and -2**63 <= v < 2**63


def is_number(v):
    return isinstance(v, (int, float)) and not isinstance(v, bool)


def get(o, key, kind, required=False, low=None, high=None):
    """A field of an object, checked; None where it is absent."""
    if key not in o:
        if required:
            raise Wrong("lacks " + key)
        return None
    v = o[key]
    good = {"int": is_int, "number": is_number, "text": lambda x: isinstance(x, str),
            "bool": lambda x: isinstance(x, bool), "list": lambda x: isinstance(x, list),
            "object": lambda x: isinstance(x, dict)}[kind](v)
    if not good or (low is not None and v < low) or (high is not None and v > high):
        raise Wrong("%s is wrong: %r" % (key, v))
    return v


def cut(text, limit):
    """A free text that is longer than the format gives is cut, at a whole character."""
    return None if text is None else text.encode()[:limit].decode(errors="ignore")


def text_of(o, key, limit, required=False):
    return cut(get(o, key, "text", required), limit)


def id_of(o, key, limit, required=False):
    v = get(o, key, "text", required)
    if v is not None and len(v.encode()) > limit:
        raise Wrong("%s is too long" % key)
    return v


def present(**fields):
    """What does not apply is absent."""
    return {k: v for k, v in fields.items() if v is not None}


def no_duplicates(pairs):
    if len({k for k, _ in pairs}) != len(pairs):
        raise Wrong("a key stands there twice")
    return dict(pairs)


def parse(data):
    try:
        text = data.decode("utf-8")
        o = json.loads(text, object_pairs_hook=no_duplicates)
    except ValueError as e:
        raise Wrong("no JSON: %s" % e) from None
    if not isinstance(o, dict) or "\\u0000" in text:
        raise Wrong("no JSON object as the format has it")
    return o


def good_path(path):
    return len(path.encode()) <= 191 and all(NAME.fullmatch(n) for n in path.split("/"))


def file_of(o):
    path = get(o, "path", "text", True)
    if not good_path(path):
        raise Wrong("a path leads astray: %r" % path)
    sha = get(o, "sha256", "text", True)
    if not HEX64.fullmatch(sha):
        raise Wrong("no sha256: %r" % sha)
    return {"path": path, "bytes": get(o, "bytes", "int", True, 0), "sha256": sha}


REGION = ("x", "y", "width", "height")


def sample_of(o):
    """One of samples.json."""
    if not isinstance(o, dict):
        raise Wrong("a sample is no object")
    region = get(o, "region", "object", True)
    if not id_of(o, "id", 63, True):
        raise Wrong("an id is empty")
    return present(id=o["id"], title=text_of(o, "title", 127) or None,
                   treatment=text_of(o, "treatment", 255) or None,
                   region={k: get(region, k, "int", True, int(k in ("width", "height")), 2**31 - 1)
                           for k in REGION})


def raw_of(data):
    """Size, levels, mosaic and the crc of the samples of a DNG of 16 bits in uncompressed strips."""
    tags = tiff_tags(data)
    if tags is None or tags.get(259, (1,))[0] != 1 or tags.get(258) != (16,) or 273 not in tags:
        return {}
    samples = b"".join(data[o:o + n] for o, n in zip(tags[273], tags[279]))
    cfa = tags.get(33422)
    return {"width": tags[256][0], "height": tags[257][0], "black": tags.get(50714, (0,))[0],
            "white": tags.get(50717, (65535,))[0],
            "cfa": "".join("RGB"[c] for c in cfa) if cfa else "none", "crc": zlib.crc32(samples)}


SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 7: 1, 13: 4}  # of the kinds of values that are read


def tiff_folder(data, at):
    """The tags of one folder of a little-endian TIFF: what kind of values, and their bytes."""
    tags = {}
    for i in range(struct.unpack_from("<H", data, at)[0]):
        tag, kind, count, where = struct.unpack_from("<HHII", data, at + 2 + 12 * i)
        if kind in SIZES:
            n = count * SIZES[kind]
            start = at + 10 + 12 * i if n <= 4 else where
            tags[tag] = kind, data[start:start + n]
    return tags


def numbers(kind, value):
    """Integers; unsigned fractions exact."""
    if kind == 5:
        pairs = struct.unpack("<%dI" % (len(value) // 4), value)
        return tuple(Fraction(n, d) if d else 0 for n, d in zip(pairs[::2], pairs[1::2]))
    return struct.unpack("<%d%s" % (len(value) // SIZES[kind], {1: "B", 3: "H", 4: "I", 13: "I"}[kind]), value)


def first_folder(data):
    return tiff_folder(data, struct.unpack_from("<I", data, 4)[0]) if data[:4] == b"II*\0" else None


def tiff_tags(data):
    """The first page's tags of bytes, integers and unsigned fractions that are whole."""
    folder = first_folder(data)
    return folder and {tag: tuple(int(n) for n in numbers(kind, value))
                       for tag, (kind, value) in folder.items() if kind not in (2, 7)}


# What an image says of itself, one developed or beside it: its colours (ICC.1:2010) and when it was taken (Exif 2.31)

def curve_is_straight(data):
    """A tone curve, as ICC.1 has it in `curv` (10.5) and `para` (10.15), that changes nothing."""
    kind, n = data[:4], struct.unpack_from(">I", data, 8)[0]
    if kind == b"curv" and n <= 1:
        return n == 0 or struct.unpack_from(">H", data, 12)[0] == 256
    if kind == b"curv":
        values = struct.unpack_from(">%dH" % n, data, 12)
        return all(abs(v - 65535 * i / (n - 1)) < 16 for i, v in enumerate(values))
    if kind == b"para":
        function = n >> 16
        gamma, *more = (v / 65536 for v in struct.unpack_from(
            ">%di" % (1, 3, 4, 5, 7)[function], data, 12))
        return gamma == 1 and function == 0 or function > 0 and gamma == 1 and more[:2] == [1, 0] and (
            function != 3 or more[2] == 1)
    return False


def profile_is_linear(data):
    """None: it is no profile, or says nothing of tone."""
    if len(data) < 132 or data[36:40] != b"acsp":
        return None
    tags = {}
    for i in range(struct.unpack_from(">I", data, 128)[0]):
        name, at, n = struct.unpack_from(">4sII", data, 132 + 12 * i)
        tags[name] = data[at:at + n]
    wanted = [b"kTRC"] if data[16:20] == b"GRAY" else [b"rTRC", b"gTRC", b"bTRC"]
    if any(w not in tags for w in wanted):
        return None
    return all(curve_is_straight(tags[w]) for w in wanted)


def text_in(folder, *tags):
    for tag in tags:
        if tag in folder and folder[tag][0] == 2:
            return folder[tag][1].split(b"\0")[0].decode("ascii", "replace")
    return None


def times_of(data, folder):
    """The start of the exposure and how long it was."""
    exif = tiff_folder(data, numbers(*folder[34665])[0]) if 34665 in folder else {}
    date = text_in(exif, 36867) or text_in(folder, 306)
    start = zone = exposure = None
    if date and (m := re.fullmatch(r"(\d{4}):(\d\d):(\d\d) (\d\d):(\d\d):(\d\d)", date)):
        year, month, day, h, minute, s = map(int, m.groups())
        days = datetime.date(year, month, day).toordinal() - datetime.date(1970, 1, 1).toordinal()
        start = (days * 86400 + h * 3600 + minute * 60 + s) * 10**9
        start += int((text_in(exif, 37521) or "").ljust(9, "0")[:9])
        offset = re.fullmatch(r"([+-])(\d\d):(\d\d)", text_in(exif, 36881, 36880) or "")
        if offset:
            zone = (int(offset[2]) * 3600 + int(offset[3]) * 60) * (-1 if offset[1] == "-" else 1)
            start -= zone * 10**9
    if 33434 in exif:
        exposure = round(numbers(*exif[33434])[0] * 10**9)
    return present(start_utc_ns=start, zone_offset_s=zone, exposure_ns=exposure)


def picture_of(data):
    """None of what is no little-endian TIFF."""
    folder = first_folder(data)
    if not folder:
        return None
    tags = tiff_tags(data)
    linear = profile_is_linear(folder[34675][1]) if 34675 in folder else None
    bits, kind = tags.get(258, (1,))[0], tags.get(339, (1,))[0]
    return {"width": tags[256][0], "height": tags[257][0], "samples": tags.get(277, (1,))[0],
            "sample_format": "f32" if kind == 3 else "u%d" % bits,
            "orientation": tags.get(274, (1,))[0], "icc": 34675 in folder,
            "linear": bits != 8 if linear is None else linear, **times_of(data, folder)}


def tiff_mean(data, stream):
    """The mean of the codes of a TIFF in strips, uncompressed or deflated; None of any other."""
    tags = tiff_tags(data)
    if tags is None:
        return None
    packed = tags.get(259, (1,))[0]
    if packed not in (1, 8) or tags.get(317, (1,))[0] != 1 or 273 not in tags:
        return None
    strips = [data[o:o + n] for o, n in zip(tags[273], tags[279])]
    pixels = b"".join(zlib.decompress(s) if packed == 8 else s for s in strips)
    n = tags[256][0] * tags[257][0] * tags.get(277, (1,))[0]
    if tags.get(258, (1,))[0] != SAMPLE_BITS[stream["sample_format"]]:
        return None
    return sum(struct.unpack_from("<%d%s" % (n, FORMATS[stream["sample_format"]]), pixels)) / n


class Reader:
    def __init__(self, folder):
        self.folder = folder
        self.findings = []
        self.plans, self.segments, self.calibrations, self.slots = [], [], {}, []
        self.n_plans = 0
        self.end, self.ended, self.line_slot = None, False, None
        self.named = {}        # path: (file, slot or None) of all that records name
        self.image_paths = []  # in the order of the records

    def find(self, kind, path, text, slot=None, line=None):
        self.findings.append({"class": kind, "path": path, "text": text,
                              **present(slot=slot, line=line)})

    def bytes_of(self, path):
        try:
            with open(os.path.join(self.folder, path), "rb") as f:
                return f.read()
        except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
            return None

    # dataset.json

    def manifest(self):
        data = self.bytes_of("dataset.json")
        if data is None:
            raise Refused("no dataset.json: no dataset (yet)")
        try:
            return self.checked_manifest(parse(data))
        except Wrong as e:
            raise Refused("dataset.json: %s" % e) from None

    def checked_manifest(self, o):
        f = get(o, "format", "object", True)
        if get(f, "name", "text", True) != "ttf" or get(f, "major", "int", True) != 1:
            raise Wrong("not of this format and major version")
        for name in get(f, "required", "list") or []:
            raise Wrong("needs %r, which this reader does not know" % name)
        uuid = get(o, "uuid", "text", True)
        if not UUID.fullmatch(uuid):
            raise Wrong("no uuid: %r" % uuid)
        streams = [s for s in (self.stream(s) for s in get(o, "streams", "list", True)) if s]
        primary = [s for s in streams if s.get("primary")]
        if not streams or len(primary) > 1 or len({s["id"] for s in streams}) != len(streams):
            raise Wrong("streams are wrong")
        self.streams = {s["id"]: s for s in streams}
        self.primary = (primary or streams)[0]
        group, parent = get(o, "group", "object"), get(o, "derived_from", "object")
        if group is not None:
            get(group, "uuid", "text", True)
        for of in (group or {}), (parent or {}):
            if not UUID.fullmatch(get(of, "uuid", "text") or uuid):
                raise Wrong("no uuid: %r" % of["uuid"])
        if not HEX64.fullmatch(get(parent or {}, "digest", "text") or 64 * "0"):
            raise Wrong("no digest: %r" % parent["digest"])
        for key, most in (("cameras", 4), ("channels", 16), ("streams", 16)):
            if len(get(o, key, "list") or []) > most:
                raise Wrong("more than %d %s" % (most, key))
        for s in streams:
            for key, of in (("camera", "cameras"), ("channel", "channels")):
                if s.get(key) and s[key] not in [c.get("id") for c in get(o, of, "list") or []]:
                    raise Wrong("stream %s is of no %s" % (s["id"], key))
        return present(
            minor=get(f, "minor", "int", True, 0), uuid=uuid, title=text_of(o, "title", 127),
            simulated=get(o, "simulated", "bool", True),
            rehearsal=get(o, "rehearsal", "bool") or None,
            box_serial=text_of(o, "box_serial", 63), software=text_of(o, "software", 63),
            cameras=[present(id=id_of(c, "id", 31, True), model=text_of(c, "model", 63),
                             raw_width=get(c, "raw_width", "int", False, 1, 65535),
                             raw_height=get(c, "raw_height", "int", False, 1, 65535),
                             cfa=text_of(c, "cfa", 7),
                             raw_bits=get(c, "raw_bits", "int", False, 1, 64))
                     for c in get(o, "cameras", "list") or []] or None,
            channels=[present(id=id_of(c, "id", 31, True), title=text_of(c, "title", 95))
                      for c in get(o, "channels", "list") or []] or None,
            streams=streams,
            group=group and present(uuid=get(group, "uuid", "text"),
                                    member=text_of(group, "member", 31)),
            source=text_of(o, "source", 255),
            derived_from=parent and present(
                uuid=get(parent, "uuid", "text"), digest=get(parent, "digest", "text"),
                command=text_of(parent, "command", 255), seed=get(parent, "seed", "int")))

    @staticmethod
    def stream(s):
        name = get(s, "id", "text", True)
        if not re.fullmatch("[a-z0-9-]{1,31}", name):
            raise Wrong("stream id is wrong: %r" % name)
        sample_format = get(s, "sample_format", "text", True)
        if sample_format not in FORMATS:
            if get(s, "primary", "bool"):
                raise Wrong("the primary stream has samples of %r" % sample_format)
            return None
        code = get(s, "encoding", "object", True)
        if get(code, "scale", "number", True) == 0:
            raise Wrong("scale is 0")
        per_px = get(s, "mm_per_px", "number")
        if per_px is not None and per_px <= 0:
            raise Wrong("mm_per_px is wrong")
        return present(
            id=name, camera=id_of(s, "camera", 31), channel=id_of(s, "channel", 31),
            quantity=text_of(s, "quantity", 31, True), unit=text_of(s, "unit", 31) or "1",
            width=get(s, "width", "int", True, 1, 65535),
            height=get(s, "height", "int", True, 1, 65535),
            samples=get(s, "samples", "int", True, 1, 255), sample_format=sample_format,
            pedestal=float(get(code, "pedestal", "number", True)), scale=float(code["scale"]),
            colour_space=text_of(s, "colour_space", 31) or "none", mm_per_px=per_px,
            primary=get(s, "primary", "bool") or None)

    # Lines

    def lines(self, path):
        """The good lines of a file as objects; the bad ones become findings."""
        data = self.bytes_of(path)
        if data is None:
            return
        *terminated, tail = data.split(b"\n")
        seq = number = 0
        for number, line in enumerate(terminated, 1):
            try:
                o = self.line(line)
            except Wrong as e:
                self.find("damage", path, str(e), line=number)
                seq += 1
                continue
            if o["seq"] != seq:
                self.find("damage", path, "seq is %d, not %d" % (o["seq"], seq), line=number)
            seq = o["seq"] + 1
            yield number, o
        torn = "damage" if self.sealed else "leftover"
        at = 0
        for match in CRC_END.finditer(tail):
            try:
                o = self.line(tail[:match.end()])
            except Wrong:
                continue
            at = match.end()
            self.find(torn, path, "the last line's LF is missing", line=number + 1)
            yield number + 1, o
            break
        if tail[at:]:
            self.find(torn, path, "%d bytes of a line cut off" % len(tail[at:]))

    @staticmethod
    def line(line):
        end = CRC_END.fullmatch(line[-18:])
        if not end or int(end.group(1), 16) != zlib.crc32(line[:-18]):
            raise Wrong("the crc is wrong")
        o = parse(line)
        if list(o)[:2] != ["type", "seq"] or len(line) > 16 << 20:
            raise Wrong("type and seq do not come first")
        get(o, "type", "text", True)
        get(o, "seq", "int", True)
        return o

    # records.jsonl

    def records(self):
        if self.bytes_of("records.jsonl") is None:
            self.find("damage", "records.jsonl", "is missing")
            return
        known = {"plan": self.plan, "segment": self.segment, "calibration": self.calibration,
                 "slot": self.slot, "end": self.ending}
        for number, o in self.lines("records.jsonl"):
            if o["type"] not in known:
                continue
            try:
                self.ended = o["type"] == "end"
                known[o["type"]](o)
            except Wrong as e:
                self.find("damage", "records.jsonl", "%s: %s" % (o["type"], e), line=number,
                          slot=o.get("index") if o["type"] == "slot" else None)

    def name(self, file, slot=None):
        before = self.named.setdefault(file["path"], (file, slot))
        if before[0]["sha256"] != file["sha256"]:  # it cannot be both
            self.find("damage", file["path"], "is named twice, with other contents", slot)
        return file

    def plan(self, o):
        due = self.n_plans
        self.n_plans += 1
        number = get(o, "plan", "int", True, 0)
        files = get(o, "files", "list", True)
        if number > due and self.records_damaged():  # one of them may have been the damaged line
            self.n_plans = number + 1
        elif number != due:
            raise Wrong("plan %d comes where plan %d is due" % (number, due))
        self.plans.append({"plan": number, "files": [self.name(file_of(f)) for f in files]})

    def segment(self, o):
        number = get(o, "segment", "int", True, 0)
        trust = get(o, "trust", "text", True)
        plan = get(o, "plan", "int")
        if plan is not None and not 0 <= plan < self.n_plans:
            raise Wrong("no plan %d before it" % plan)
        segment = present(
            segment=number, first_index=get(o, "first_index", "int", True, 0),
            boot_id=id_of(o, "boot_id", 36), origin_ns=get(o, "origin_ns", "int", True),
            origin_utc_ns=get(o, "origin_utc_ns", "int"), trust=trust,
            uncertainty_ns=get(o, "uncertainty_ns", "int", False, 0),
            interval_ns=get(o, "interval_ns", "int", True, 0), plan=plan,
            zone=text_of(o, "zone", 63), zone_offset_s=get(o, "zone_offset_s", "int"),
            corrects=get(o, "corrects", "bool") or None, run_ns=get(o, "run_ns", "int", False, 0) or None,
            run_utc_ns=get(o, "run_utc_ns", "int", False, 0) or None, run_trust=text_of(o, "run_trust", 7),
            dataset_sha256=get(o, "dataset_sha256", "text"), box=text_of(o, "box", 255))
        sha = get(o, "dataset_sha256", "text")
        if sha is not None:
            if not HEX64.fullmatch(sha):
                raise Wrong("dataset_sha256 is none")
            self.name({"path": "dataset.json", "bytes": None, "sha256": sha})
        if "gap_ns" in o:
            segment["gap_ns"] = o["gap_ns"] and get(o, "gap_ns", "int", False, 1)
        if number > len(self.segments):
            raise Wrong("segments are not in order")
        self.segments[number:number + 1] = [segment]

    def calibration(self, o):
        name = id_of(o, "id", 63, True)
        if not name:
            raise Wrong("id is empty")
        self.calibrations[name] = [self.name(file_of(f)) for f in get(o, "files", "list", True)]

    def ending(self, o):
        self.end = present(reason=text_of(o, "reason", 63), slots=get(o, "slots", "int", True, 0),
                           **{r: get(o, r, "int", False, 0) for r in RESULTS})
        there = self.counts()
        if not self.records_damaged() and (self.end["slots"] != len(self.slots) or any(
                there[r] != (self.end.get(r) or 0) for r in RESULTS)):
            raise Wrong("counts other slots than there are")

    def records_damaged(self):
        return any(f["class"] == "damage" and f["path"] == "records.jsonl" for f in self.findings)

    def counts(self):
        return {r: sum(s["result"] == r for s in self.slots) for r in RESULTS}

    def slot(self, o):
        index = get(o, "index", "int", True, 0)
        segment = get(o, "segment", "int", True)
        result = get(o, "result", "text", True)
        if self.slots and index <= self.slots[-1]["index"]:
            raise Wrong("slot %d comes too late" % index)
        if not 0 <= segment < len(self.segments):
            raise Wrong("no segment %d before it" % segment)
        if result not in RESULTS:
            raise Wrong("result is wrong: %r" % result)
        images = [self.image(i, index) for i in get(o, "images", "list") or []]
        keys = [(i["stream"], i.get("bracket", {}).get("index")) for i in images]
        if len(set(keys)) != len(keys):
            raise Wrong("two images of one stream and bracket")
        if result == "captured" and any("lacking" in i for i in images):
            raise Wrong("is captured and lacks an image")
        self.slots.append(present(
            index=index, segment=segment, due_ns=get(o, "due_ns", "int", True),
            middle_ns=get(o, "middle_ns", "int"), result=result,
            reason=text_of(o, "reason", 159, result != "captured"),
            sensors=[present(name=text_of(s, "name", 31, True), kind=text_of(s, "kind", 23, True),
                             ok=get(s, "ok", "bool", True), value=get(s, "value", "int"))
                     for s in get(o, "sensors", "list") or []] or None,
            images=images or None))

    def image(self, o, index):
        calibration = id_of(o, "calibration", 63)
        if calibration is not None and calibration not in self.calibrations and not (
                self.records_damaged() and os.path.isdir(
                    os.path.join(self.folder, "calibration", calibration))):
            raise Wrong("no calibration %r before it" % calibration)
        stream = get(o, "stream", "text", True)
        files = [dict(role=get(f, "role", "text", True), **self.name(file_of(f), index))
                 for f in get(o, "files", "list") or []]
        self.image_paths += [f["path"] for f in files]
        if not files and "lacking" not in o:
            raise Wrong("an image without files does not say why")
        if stream not in self.streams:
            self.find("note", "records.jsonl", "dataset.json does not list stream %s" % stream,
                      slot=index)
        bracket = get(o, "bracket", "object")
        return present(
            stream=stream, bracket=bracket and self.bracket(bracket),
            lacking=text_of(o, "lacking", 63), n_averaged=get(o, "n_averaged", "int", False, 1),
            calibration=calibration,
            shots=[self.shot(s) for s in get(o, "shots", "list") or []] or None,
            mean_level=get(o, "mean_level", "number"),
            reference_level=get(o, "reference_level", "number"),
            sharpness=get(o, "sharpness", "number"),
            flags=get(o, "flags", "list") or None, files=files or None)

    @staticmethod
    def bracket(o):
        exposure = get(o, "relative_exposure", "number")
        if exposure is not None and exposure <= 0:
            raise Wrong("relative_exposure is not more than 0")
        return present(index=get(o, "index", "int", True, 0), relative_exposure=exposure)

    @staticmethod
    def shot(o):
        def settings(s):
            return s and present(exposure_ns=get(s, "exposure_ns", "int", True), **{
                k: get(s, k, "int") for k in ("gain_milli", "wb_r_milli", "wb_b_milli",
                                              "lens_mdpt")})
        return present(
            asked=settings(get(o, "asked", "object")), granted=settings(get(o, "granted", "object")),
            start_ns=get(o, "start_ns", "int"), end_ns=get(o, "end_ns", "int"),
            refused=text_of(o, "refused", 63),
            lamps=[present(name=text_of(x, "name", 31, True),
                           commanded_permille=get(x, "commanded_permille", "int"),
                           measured_permille=get(x, "measured_permille", "int"))
                   for x in get(o, "lamps", "list") or []] or None)

    # Files

    def check_named(self):
        for path, (file, slot) in self.named.items():
            data = self.bytes_of(path)
            if data is None:
                self.find("damage", path, "is missing", slot)
            elif file["bytes"] not in (None, len(data)):
                self.find("damage", path, "has %d bytes of %d" % (len(data), file["bytes"]), slot)
            elif hashlib.sha256(data).hexdigest() != file["sha256"]:
                self.find("damage", path, "is not what it was", slot)

    def all_files(self):
        for folder, folders, files in os.walk(self.folder):
            folders[:] = sorted(n for n in folders if NAME.fullmatch(n) and (
                folder != self.folder or n != "preview"))
            for name in sorted(files):
                if NAME.fullmatch(name):
                    yield os.path.relpath(os.path.join(folder, name), self.folder)

    def sums(self):
        """Lines of SHA256SUMS as (path, hash); a last one that was cut off is left over."""
        data = self.bytes_of("SHA256SUMS") or b""
        lines, tail = data.split(b"\n")[:-1], data.split(b"\n")[-1]
        pairs, offset = [], 0
        for line in lines:
            m = SUM.fullmatch(line)
            zeros = [i for i, c in enumerate(line) if c == 0]
            hole = len(zeros) > 1 or (zeros and (zeros[0] not in (64, 65) or
                                                 (offset + zeros[0]) % 512 in (0, 511)))
            offset += len(line) + 1
            pairs.append((m.group(2).decode(errors="replace"), m.group(1).decode())
                         if m and not zeros else HOLE if hole else None)
        return pairs, tail

    def check_sums(self):
        listed, tail = self.sums()
        if self.sealed:
            self.check_seal(listed, tail)
        else:
            self.check_temporary()
            if not self.records_damaged():
                self.check_running(listed, tail)
                self.check_strays()

    def check_temporary(self):
        for path in self.all_files():
            if path.endswith(".tmp"):
                self.find("leftover", path, "was being written")

    def check_seal(self, listed, tail):
        if tail or None in listed or HOLE in listed:
            self.find("damage", "SHA256SUMS", "is not as the seal has it")
        if not self.ended:
            self.find("damage", "records.jsonl", "the dataset is sealed and has not ended")
        if self.rehearsal:
            self.find("damage", "dataset.json", "a rehearsal is sealed")
        listed = [x for x in listed if x and x != HOLE]
        if not all(good_path(path) for path, _ in listed):
            self.find("damage", "SHA256SUMS", "lists what cannot lie in the dataset")
        listed = [x for x in listed if good_path(x[0])]
        paths = [path.encode() for path, _ in listed]
        if paths != sorted(set(paths)):
            self.find("damage", "SHA256SUMS", "is not sorted by the bytes of the paths")
        listed = dict(listed)
        known = {f["path"] for f in self.findings if f["class"] == "damage"}
        for path, sha in listed.items():
            file, slot = self.named.get(path, (None, None))
            data = self.bytes_of(path)
            if file and file["sha256"] != sha:
                self.find("damage", "SHA256SUMS", "gives %s another hash than its record" % path)
                continue
            if path in known and path in self.named:
                continue
            if data is None:
                self.find("damage", path, "is missing", slot)
            elif hashlib.sha256(data).hexdigest() != sha:
                self.find("damage", path, "is not what was sealed", slot)
        for path in self.all_files():
            if path in listed or path in UNSEALED:
                continue
            if path.endswith(".tmp"):
                self.find("leftover", path, "was being written")
            elif path in self.named or path in ("dataset.json", "events.jsonl") or (
                    path.split("/")[0] in ("frames", "raw", "plans", "calibration")):
                self.find("damage", path, "is not in SHA256SUMS", self.named.get(path, (0, None))[1])
            else:
                self.find("note", path, "is not in SHA256SUMS")

    def check_running(self, listed, tail):
        by_hash = {f["sha256"] for f, _ in self.named.values()}
        behind = tail or len(listed) < len(self.image_paths)
        for pair in listed:
            if pair == HOLE:
                behind = True
            elif pair is None:
                self.find("damage", "SHA256SUMS", "has a line that is none")
            elif pair[0] in self.named and pair[1] == self.named[pair[0]][0]["sha256"] and \
                    pair[0].split("/")[0] in ("frames", "raw"):
                continue
            elif pair[0] in self.named or pair[1] in by_hash:
                self.find("damage", "SHA256SUMS", "says of %s what no record does" % pair[0])
            elif pair[0].split("/")[0] in ("frames", "raw"):
                self.find("damage", "records.jsonl", "has lost the slot of %s" % pair[0])
            else:
                self.find("damage", "SHA256SUMS", "is of a seal and lists %s" % pair[0])
        if behind and not any(f["class"] == "damage" and f["path"] in ("SHA256SUMS", "records.jsonl")
                              for f in self.findings):
            self.find("leftover", "SHA256SUMS", "is behind the records")

    def check_strays(self):
        last = self.slots[-1]["index"] if self.slots else -1
        new = []
        for path in self.all_files():
            folder = path.split("/")[0]
            number = re.match("[0-9]+", path.split("/")[-1])
            if path.endswith(".tmp") or path in self.named or path in UNSEALED:
                continue
            elif folder in ("plans", "calibration"):
                self.find("leftover", path, "its line never came")
            elif folder in ("frames", "raw"):
                if number and int(number.group()) > last:
                    new.append((path, int(number.group())))
                else:
                    self.find("note", path, "no record names it")
        for path, index in new:
            one = len({i for _, i in new}) == 1
            self.find("leftover" if one else "note", path, "no record names it (yet)", index)

    # Everything

    def pixels(self):
        """The mean value of each developed image, beside what its record says."""
        for slot in self.slots:
            for image in slot.get("images", []):
                for f in image.get("files", []):
                    if f["role"] == "raw":
                        image["raw"] = raw_of(self.bytes_of(f["path"]) or b"")
                stream = self.streams.get(image["stream"])
                for f in image.get("files", []) if stream else []:
                    data = self.bytes_of(f["path"]) if f["role"] in PICTURES else None
                    if data is None or hashlib.sha256(data).hexdigest() != f["sha256"]:
                        continue
                    image.update(present(**{f["role"]: picture_of(data)}))
                    mean = tiff_mean(data, stream) if f["role"] == "developed" else None
                    if mean is not None:
                        image["pixel_mean"] = (mean - stream["pedestal"]) / stream["scale"]

    def notes(self):
        notes = []
        for line in (self.bytes_of("notes.jsonl") or b"").splitlines():
            try:
                note = parse(line)
                for first, last in note.get("slots", []) if isinstance(note, dict) else []:
                    if not 0 <= first <= last:
                        raise Wrong("slots has %s to %s, which is no slot at all" % (first, last))
                notes.append(note)
            except (TypeError, ValueError) as e:
                self.find("note", "notes.jsonl", "slots must be of pairs: %s" % e)
            except Wrong as e:
                self.find("note", "notes.jsonl", str(e))
        return notes

    def samples(self):
        data = self.bytes_of("samples.json")
        try:
            samples = [] if data is None else [
                sample_of(o) for o in get(parse(data), "samples", "list", True)]
            if len({s["id"] for s in samples}) != len(samples):
                raise Wrong("an id stands there twice")
        except Wrong as e:
            self.find("note", "samples.json", str(e))
            return []
        primary = self.primary
        for s in samples:
            x, y, width, height = (s["region"][k] for k in REGION)
            if primary and (x + width > primary["width"] or y + height > primary["height"]):
                self.find("note", "samples.json", "%s lies outside of the picture" % s["id"])
        return samples

    def summary(self):
        listed, tail = self.sums()
        self.sealed = any(x and x[0] == "records.jsonl" for x in listed) or bool(
            SUM.fullmatch(tail) and tail.endswith(b"  records.jsonl"))
        manifest = self.manifest()
        self.rehearsal = manifest.get("rehearsal")
        self.records()
        if not self.sealed and self.bytes_of("events.jsonl") is None:
            self.find("note", "events.jsonl", "is missing")
        events = [o for _, o in self.lines("events.jsonl") if o["type"] == "event"]
        self.check_named()
        self.check_sums()
        self.pixels()
        for slot in self.slots:
            segment = self.segments[slot["segment"]]
            if "origin_utc_ns" in segment:
                slot["due_utc_ns"] = (segment["origin_utc_ns"] + slot["due_ns"]
                                      - segment["origin_ns"])
        digest = self.bytes_of("SHA256SUMS") if self.sealed else None
        damaged = any(f["class"] == "damage" for f in self.findings)
        return present(
            manifest=manifest, plans=self.plans, segments=self.segments,
            calibrations=[{"id": i, "files": f} for i, f in self.calibrations.items()],
            slots=self.slots, counts=self.counts(), end=self.end, ended=self.ended,
            sealed=self.sealed, digest=digest and hashlib.sha256(digest).hexdigest(),
            events=[{k: v for k, v in e.items() if k not in ("type", "crc")} for e in events],
            notes=self.notes(), samples=self.samples(), findings=self.findings,
            exit=3 if damaged else 0)


def main():
    try:
        summary = Reader(sys.argv[1]).summary()
    except Refused as e:
        print("%s: %s" % (sys.argv[1], e), file=sys.stderr)
        return 1
    json.dump(summary, sys.stdout, indent=1, sort_keys=True)
    print()
    return summary["exit"]


if __name__ == "__main__":
    sys.exit(main())
