#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Two readers, one of them the program, must say the same of the same dataset.

    agree.py TTFBOX DUMP FOLDER [DATASET...]

Makes datasets in FOLDER (by make.py, and by the program itself), damages copies of the former in
every way that FORMAT.md tells apart, and compares `ttfbox verify --json`, `info --json` and every field that our reader reads (dump.c) with read.py. What is
given besides (a capture, an import) is compared as it is.
"""
import hashlib
import json
import os
import shutil
import subprocess
import sys
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))


def run(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    try:
        return done.returncode, json.loads(done.stdout)
    except ValueError:
        return done.returncode, None


def write(path, data):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as f:
        f.write(data)


def read(path):
    with open(path, "rb") as f:
        return f.read()


def lines_of(folder):
    return read(folder + "/records.jsonl").split(b"\n")[:-1]


def put_lines(folder, lines):
    write(folder + "/records.jsonl", b"".join(l + b"\n" for l in lines))


def edited(line, **fields):
    """The line with other fields (None: without it) and a crc that holds."""
    o = json.loads(line)
    del o["crc"]
    for key, value in fields.items():
        o.pop(key, None) if value is None else o.update({key: value})
    text = json.dumps(o, separators=(",", ":"))[:-1].encode()
    return text + b',"crc":"%08x"}' % zlib.crc32(text)


def edit_line(kind, nth=0, **fields):
    def change(folder):
        lines = lines_of(folder)
        at = [i for i, l in enumerate(lines) if json.loads(l)["type"] == kind][nth]
        lines[at] = edited(lines[at], **fields)
        put_lines(folder, lines)
    return change


def flip(path, at, bit=0):
    def change(folder):
        data = bytearray(read(folder + "/" + path))
        data[at] ^= 1 << bit
        write(folder + "/" + path, bytes(data))
    return change


def put(path, data):
    return lambda folder: write(folder + "/" + path, data)


def cut(path, n):
    return lambda folder: write(folder + "/" + path, read(folder + "/" + path)[:-n])


def more(path, data):
    return lambda folder: write(folder + "/" + path, read(folder + "/" + path) + data)


def gone(path):
    return lambda folder: os.unlink(folder + "/" + path)


def added(**fields):
    """One more line, in its turn."""
    def change(folder):
        lines = lines_of(folder)
        put_lines(folder, lines + [edited(b'{"crc":0}', type=fields.pop("kind"), seq=len(lines), **fields)])
    return change


def manifest(**fields):
    def change(folder):
        o = json.loads(read(folder + "/dataset.json"))
        o.update(fields)
        write(folder + "/dataset.json", json.dumps(o).encode())
    return change


def sealed_anew(folder):
    """The list with the hashes of what lies there now."""
    paths = [l.split(b"  ", 1)[1].decode() for l in read(folder + "/SHA256SUMS").splitlines()]
    write(folder + "/SHA256SUMS", "".join("%s  %s\n" % (
        hashlib.sha256(read(folder + "/" + p)).hexdigest(), p) for p in paths).encode())


def sums_as(change):
    return lambda d: write(d + "/SHA256SUMS", b"".join(
        change(read(d + "/SHA256SUMS").splitlines(keepends=True))))


DOT = '{"id":"%s","region":{"x":%d,"y":0,"width":%d,"height":1}}'


def samples(*texts):
    return put("samples.json", ('{"samples":[%s]}' % ",".join(texts)).encode())


def both(*changes):
    return lambda folder: [change(folder) for change in changes]


def flip_line(kind, at):
    def change(folder):
        lines = lines_of(folder)
        n = [i for i, l in enumerate(lines) if json.loads(l)["type"] == kind][0]
        lines[n] = lines[n][:at] + bytes([lines[n][at] ^ 1]) + lines[n][at + 1:]
        put_lines(folder, lines)
    return change


def lose_line(n):
    return lambda folder: put_lines(folder, [l for i, l in enumerate(lines_of(folder)) if i != n])


def patched(path, at, n):
    """n bytes of rot."""
    def change(folder):
        data = bytearray(read(folder + "/" + path))
        at_end = at + n == 0
        data[at:None if at_end else at + n] = b"\xc3" * n
        write(folder + "/" + path, bytes(data))
    return change


OLD = b'{"type":"slot","seq":70000,"index":69990,"crc":"03377955"}'
OLD_LOG = b'00,"ok":true}],"crc":"4b825dc6"}\n' + OLD + b'\n{"type":"slot","seq":70001,"in'
SHA = "0" * 64
SPOILED = [  # of which dataset, name, what is done to a copy of it
    ("bracket", "flip-frame", flip("frames/main/000001.b1.tif", 190)),
    ("bracket", "flip-record", flip("records.jsonl", 400)),
    ("bracket", "flip-manifest", flip("dataset.json", 60)),
    ("bracket", "major-flipped", put("dataset.json", b'{"format":{"name":"ttf","major":3,"minor":0}}')),
    ("bracket", "short", cut("frames/main/000002.b0.tif", 3)),
    ("bracket", "missing", gone("frames/main/000000.b2.tif")),
    ("bracket", "added-frame", put("frames/main/000009.tif", b"x")),
    ("bracket", "added-plan", put("plans/7.yaml", b"x")),
    ("bracket", "added-root", put("README.txt", b"x")),
    ("bracket", "added-folder", put("mine/x.txt", b"x")),
    ("bracket", "added-tmp", put("frames/main/000009.tif.tmp", b"x")),
    ("bracket", "added-hidden", put(".mine", b"x")),
    ("bracket", "outside", put("notes.jsonl", b'{"text":"fine"}\n')),
    ("bracket", "sealed-and-longer", more("records.jsonl", b'{"type":"sl')),
    ("bracket", "sums-cut", cut("SHA256SUMS", 1)),
    ("bracket", "sums-hash", flip("SHA256SUMS", 3)),
    ("bracket", "sums-line-gone", lambda d: write(d + "/SHA256SUMS", b"\n".join(
        read(d + "/SHA256SUMS").split(b"\n")[1:]))),
    ("three-segments", "torn", more("records.jsonl", b'{"type":"slot","se')),
    ("three-segments", "torn-event", more("events.jsonl", b'{"ty')),
    ("three-segments", "old-log", more("records.jsonl", OLD_LOG)),
    ("three-segments", "old-log-for-a-newline", both(cut("records.jsonl", 1), more("records.jsonl", OLD_LOG))),
    ("three-segments", "old-log-of-events", more("events.jsonl", OLD_LOG)),
    ("three-segments", "old-log-of-a-line", more("records.jsonl", OLD_LOG[:32])),
    ("three-segments", "bad-sector-at-the-end", patched("records.jsonl", -512, 512)),
    ("three-segments", "bad-sector-with-lines-at-the-end", both(cut("records.jsonl", 700), more("records.jsonl", b"\xc3\xc3\n" * 233 + b"\xc3"))),
    ("three-segments", "old-log-that-may-be-ours", lambda d: more("records.jsonl", b"\xc3\n" + edited(
        b'{"crc":0}', type="x", seq=len(lines_of(d)) + 1) + b"\n{")(d)),
    ("three-segments", "old-log-behind-a-flip", both(flip("records.jsonl", -40), more("records.jsonl", b'{"type":"sl'))),
    ("three-segments", "rot-before-a-fragment", both(patched("records.jsonl", -60, 20), more("records.jsonl", b'{"type":"sl'))),
    ("three-segments", "rot-before-others", both(patched("records.jsonl", 700, 20), cut("records.jsonl", 1))),
    ("bracket", "old-log-behind-the-seal", more("records.jsonl", OLD_LOG)),
    ("three-segments", "no-newline", cut("records.jsonl", 1)),
    ("three-segments", "newline-lost-between", lambda d: write(
        d + "/records.jsonl", read(d + "/records.jsonl")[:-1] + b'\0{"type":"slot","seq":')),
    ("three-segments", "lost-line", lose_line(4)),
    ("three-segments", "lost-last", lose_line(-1 % 13)),
    ("three-segments", "flip-line", flip("records.jsonl", 700)),
    ("three-segments", "flip-event", flip("events.jsonl", 9)),
    ("three-segments", "sums-behind", cut("SHA256SUMS", 100)),
    ("three-segments", "sums-gone", gone("SHA256SUMS")),
    ("three-segments", "sums-hash", flip("SHA256SUMS", 3)),
    ("three-segments", "sums-path", flip("SHA256SUMS", 80)),
    ("three-segments", "sums-hole", lambda d: write(
        d + "/SHA256SUMS", bytes(30) + read(d + "/SHA256SUMS")[30:])),
    ("three-segments", "sums-noise", patched("SHA256SUMS", -50, 50)),
    ("three-segments", "sums-noise-in-a-path", patched("SHA256SUMS", 70, 9)),
    ("three-segments", "sums-wrong-blank", flip("SHA256SUMS", 64)),
    ("three-segments", "sums-wrong-newline", lambda d: flip("SHA256SUMS", read(d + "/SHA256SUMS").index(b"\n"))(d)),
    ("three-segments", "sums-wrong-in-a-path", flip("SHA256SUMS", 72, 7)),
    ("three-segments", "sums-ahead", more("SHA256SUMS", SHA.encode() + b"  frames/main/000099.tif\n")),
    ("three-segments", "sums-of-a-seal", more("SHA256SUMS", SHA.encode() + b"  events.jsonl\n")),
    ("three-segments", "one-newer-file", put("frames/main/000009.tif", b"x")),
    ("three-segments", "two-newer", lambda d: (put("frames/main/000009.tif", b"x")(d),
                                               put("frames/main/000010.tif", b"x")(d))),
    ("three-segments", "an-older-file", put("frames/main/000001.mask.tif", b"x")),
    ("three-segments", "plan-without-line", put("plans/1.yaml", b"x")),
    ("three-segments", "calibration-without-line", put("calibration/c/dark.tif", b"x")),
    ("three-segments", "no-events", gone("events.jsonl")),
    ("three-segments", "no-records", gone("records.jsonl")),
    ("three-segments", "manifest-guarded", edit_line("segment", 0, dataset_sha256=SHA)),
    ("three-segments", "no-reason", edit_line("slot", 3, reason=None)),
    ("three-segments", "captured-lacking", edit_line("slot", 8 - 2, images=[
        {"stream": "main", "lacking": "nothing"}])),
    ("three-segments", "no-files-no-reason", edit_line("slot", 6, images=[{"stream": "main"}])),
    ("three-segments", "twice-the-same", edit_line("slot", 6, images=[
        {"stream": "main", "lacking": "a"}, {"stream": "main", "lacking": "b"}],
        result="partial", reason="x")),
    ("three-segments", "result-unknown", edit_line("slot", 7, result="eaten")),
    ("three-segments", "index-falls", edit_line("slot", 7, index=2)),
    ("three-segments", "segment-unknown", edit_line("slot", 7, segment=9)),
    ("three-segments", "plan-unknown", edit_line("segment", 1, plan=4)),
    ("three-segments", "plan-comes-later", both(
        edit_line("segment", 1, plan=1), added(kind="plan", plan=1, files=[]))),
    ("gone-on-with", "run-of-no-instant", edit_line("segment", 0, run_utc_ns="noon")),
    ("gone-on-with", "run-before-1970", edit_line("segment", 0, run_utc_ns=-1)),
    ("gone-on-with", "run-lost-slots", edit_line(
        "segment", 0, run_gaps_ns=-20 * 10 ** 9, run_doubted_ns=None, run_given_up_ns=10 ** 10)),
    ("gone-on-with", "run-of-no-gaps", edit_line("segment", 0, run_gaps_ns="some")),
    ("gone-on-with", "run-of-negative-doubt", edit_line("segment", 0, run_doubted_ns=-1)),
    ("gone-on-with", "run-that-gave-up-less-than-none", edit_line("segment", 0, run_given_up_ns=-1)),
    ("gone-on-with", "run-of-no-trust", edit_line("segment", 0, run_trust=7)),
    ("three-segments", "trust-unknown", edit_line("segment", 1, trust="me")),
    ("three-segments", "no-trust", edit_line("segment", 1, trust=None)),
    ("three-segments", "segment-left-out", edit_line("segment", 1, segment=5)),
    ("three-segments", "gap-negative", edit_line("segment", 1, gap_ns=-4)),
    ("three-segments", "calibration-unknown", edit_line("slot", 0, images=[
        {"stream": "main", "calibration": "gone", "lacking": "x"}], result="partial", reason="x")),
    ("three-segments", "plan-number-wrong", edit_line("plan", 0, plan=1)),
    ("three-segments", "plan-without-number", edit_line("plan", 0, plan=None)),
    ("three-segments", "plan-without-files", edit_line("plan", 0, files=None)),
    ("three-segments", "plan-twice", added(kind="plan", plan=0, files=[])),
    ("three-segments", "plan-left-out", added(kind="plan", plan=2, files=[])),
    ("three-segments", "plan-in-order", added(kind="plan", plan=1, files=[])),
    ("three-segments", "plan-behind-damage", both(
        flip_line("plan", 30), added(kind="plan", plan=1, files=[]))),
    ("three-segments", "calibration-without-id", added(kind="calibration", files=[])),
    ("three-segments", "calibration-of-no-name", added(kind="calibration", id="", files=[])),
    ("three-segments", "calibration-without-files", added(kind="calibration", id="c")),
    ("three-segments", "calibration-only-a-folder", both(
        put("calibration/c/calibration.json", b"{}\n"), edit_line("slot", 6, images=[
            {"stream": "main", "calibration": "c", "lacking": "x"}], result="partial", reason="x"))),
    ("three-segments", "calibration-comes-later", both(
        edit_line("slot", 6, images=[{"stream": "main", "calibration": "c", "lacking": "x"}],
                  result="partial", reason="x"), added(kind="calibration", id="c", files=[]))),
    ("changed-calibration", "calibration-line-damaged", flip_line("calibration", 30)),
    ("three-segments", "no-relative-exposure", edit_line("slot", 7, images=[
        {"stream": "main", "bracket": {"index": 0}, "lacking": "x"}])),
    ("three-segments", "relative-exposure-0", edit_line("slot", 7, images=[
        {"stream": "main", "bracket": {"index": 0, "relative_exposure": 0}, "lacking": "x"}])),
    ("three-segments", "group-without-uuid", manifest(group={"member": "first"})),
    ("three-segments", "group-of-no-uuid", manifest(group={"uuid": "x"})),
    ("three-segments", "parent-of-no-digest", manifest(derived_from={"digest": "x"})),
    ("three-segments", "camera-of-none", manifest(cameras=[{"id": "a"}], streams=[{
        "id": "main", "camera": "b", "quantity": "age", "width": 4, "height": 3, "samples": 3,
        "sample_format": "u16", "encoding": {"pedestal": 0, "scale": 1}}])),
    ("three-segments", "rehearsal", manifest(rehearsal=True)),
    ("example", "rehearsal-sealed", both(
        manifest(rehearsal=True), edit_line("segment", 0, dataset_sha256=None), sealed_anew)),
    ("example", "seal-turned-round", sums_as(reversed)),
    ("example", "seal-doubled", sums_as(lambda l: l[:2] + l[1:])),
    ("example", "seal-leads-out", sums_as(lambda l: [SHA.encode() + b"  ../x\n"] + l)),
    ("three-segments", "leads-out", edit_line("slot", 7, images=[{"stream": "main", "files": [
        {"role": "raw", "path": "../x", "bytes": 1, "sha256": SHA}]}], result="captured")),
    ("three-segments", "stream-unknown", edit_line("slot", 7, images=[
        {"stream": "other", "lacking": "x"}])),
    ("three-segments", "no-role", edit_line("slot", 6, images=[{"stream": "main", "files": [
        {"path": "frames/main/000000.tif", "bytes": 224, "sha256": SHA}]}])),
    ("changed-calibration", "calibration-changed", flip("calibration/cal-b/calibration.json", 3)),
    ("example", "plan-changed", flip("plans/0.yaml", 3)),
    ("example", "end-counts-wrong", edit_line("end", 0, slots=4)),
    ("example", "notes-broken", put("notes.jsonl", b"{nonsense\n")),
    ("example", "samples-fine", samples(DOT % ("a", 0, 1), DOT % ("b", 2, 2))),
    ("example", "samples-broken", put("samples.json", b"{nonsense\n")),
    ("example", "samples-none", put("samples.json", b"{}")),
    ("example", "samples-twice", samples(DOT % ("a", 0, 1), DOT % ("a", 1, 1))),
    ("example", "samples-nameless", samples(DOT % ("", 0, 1))),
    ("example", "samples-of-no-width", samples(DOT % ("a", 0, 0))),
    ("example", "samples-before-the-picture", samples(DOT % ("a", -1, 1))),
    ("example", "samples-behind-the-picture", samples(DOT % ("a", 3, 2))),
    ("example", "samples-without-region", samples('{"id":"a"}')),
    ("example", "samples-of-a-long-title", samples(DOT % ("a", 0, 1), '{"id":"b","title":"' + "\u00fc" * 99
        + '","treatment":"","region":{"x":0,"y":0,"width":4,"height":3}}')),
]


# What both must say of these, lest they agree in overlooking it: their exit.
EXIT = {name: code for code, names in ((3, (
    "plan-number-wrong", "plan-without-number", "plan-without-files", "plan-twice", "plan-left-out",
    "plan-behind-damage", "plan-unknown", "plan-comes-later", "run-of-no-instant", "run-before-1970",
    "run-of-no-trust", "calibration-without-id", "calibration-of-no-name",
    "calibration-without-files", "calibration-only-a-folder", "calibration-comes-later",
    "calibration-line-damaged", "relative-exposure-0", "group-of-no-uuid",
    "group-without-uuid", "parent-of-no-digest",
    "camera-of-none", "rehearsal-sealed", "seal-turned-round", "seal-doubled", "seal-leads-out",
    "bad-sector-at-the-end", "bad-sector-with-lines-at-the-end", "old-log", "old-log-of-events")),
    (0, ("sums-noise", "plan-in-order", "no-relative-exposure", "rehearsal", "samples-fine", "samples-broken",
         "samples-twice", "samples-behind-the-picture")))
    for name in names}


def findings_of(found, file, severity):
    """Classes and files; where in a file and in which words is each reader's own affair."""
    return {(f[severity], f[file].split(":")[0]) for f in found}


ROLES = ("developed", "raw", "uncertainty", "mask")


def comparable(o):
    """What both readers keep: no files of unknown roles, no fields of notes that FORMAT.md does not have, no zeros in counts."""
    o = json.loads(json.dumps(o))
    for key in ("findings", "exit"):
        o.pop(key, None)
    o["manifest"].pop("minor", None)  # checked, and of no use
    for slot in o["slots"]:
        for image in slot.get("images", []):
            image.pop("pixel_mean", None)  # compared with mean_level, below
            for role in ROLES:
                if role in image:
                    image[role].pop("exposure_ns", None)  # likewise
            image["files"] = [f for f in image.get("files", []) if f["role"] in ROLES]
    for counts in (o["counts"], o.get("end", {})):
        for key in [k for k, v in counts.items() if v == 0 and k != "slots"]:
            del counts[key]
    o["notes"] = [{k: v for k, v in n.items() if k in dict(NOTE) and v} for n in o["notes"]]
    o["samples"] = [{k: v for k, v in s.items() if k in ("id", "title", "region", "treatment")}
                    for s in o["samples"]]
    return o


def different(at, a, b):
    """Where two trees differ: every field, ours and theirs."""
    if isinstance(a, dict) and isinstance(b, dict):
        return [d for k in sorted({*a, *b}) for d in different(
            at + "." + k, a.get(k, "absent"), b.get(k, "absent"))]
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        return [d for i, (x, y) in enumerate(zip(a, b)) for d in different("%s[%d]" % (at, i), x, y)]
    return [] if a == b else ["%s: %r is ours, %r theirs" % (at, a, b)]


def near(a, b):
    """Exposure times, which our reader has from libtiff in single precision."""
    return a == b or None not in (a, b) and abs(a - b) <= b * 1e-7


def tags_of_files(ours, theirs, of_its_record):
    """Exposure times in the tags of developed images, as both read them; start and exposure as the record has them, where it is told."""
    said = []
    for slot, o in zip(theirs["slots"], ours["slots"]):
        for image, other in zip(slot.get("images", []), o.get("images", [])):
            tags, at = image.get("developed") or {}, "slot %d, %s" % (slot["index"], image["stream"])
            if not near(other.get("developed", {}).get("exposure_ns"), tags.get("exposure_ns")):
                said.append("%s: exposure %r, %r" % (at, other["developed"], tags))
            shots = [s for s in image.get("shots", []) if "refused" not in s and "start_ns" in s]
            if not of_its_record or not shots:
                continue
            start = slot["due_utc_ns"] + shots[0]["start_ns"] - slot["due_ns"]
            if tags.get("start_utc_ns") != start or not near(
                    tags.get("exposure_ns"), shots[0].get("granted", {}).get("exposure_ns")):
                said.append("%s: the file's tags are not of its record: %r" % (at, tags))
    return said


def compare(box, dump, dataset):
    """What the two readers say differently."""
    r, ours = run(box, "verify", dataset, "--json")
    s, theirs = run(sys.executable, HERE + "/read.py", dataset)
    refused = [code not in (0, 3) for code in (r, s)]
    if any(refused):
        return [] if all(refused) or (s == 1 and r == 3) else ["exit %d, %d" % (r, s)]
    a = findings_of(ours["findings"], "file", "severity")
    b = findings_of(theirs["findings"], "path", "class")
    said = ["exit %d, %d" % (r, s)] if r != s else []
    said += ["only ours: %s" % (f,) for f in a - b] + ["only theirs: %s" % (f,) for f in b - a]
    if ours["sealed"] != theirs["sealed"] or ours.get("digest") != theirs.get("digest"):
        said.append("seal or digest")
    if r == 0:
        said += contents(run(box, "info", dataset, "--json")[1], theirs)
        read_by_us = run(dump, dataset)[1]
        said += different("", comparable(read_by_us), comparable(theirs)) if read_by_us else ["no dump"]
        said += tags_of_files(read_by_us, theirs, os.path.basename(
            os.path.dirname(dataset)) == "box" or dataset.endswith("average-of-8")) if read_by_us else []
    return said


def contents(info, theirs):
    said = []
    ours = {s["index"]: s for s in info["slot_list"]}
    for slot in theirs["slots"]:
        o = ours.pop(slot["index"], None)
        files = [f["path"] for i in slot.get("images", []) for f in i.get("files", [])
                 if f["role"] in ("developed", "raw", "uncertainty", "mask")]
        if not o or not set(files) <= set(o["files"]) or any(
                o.get(k) != slot.get(k) for k in ("segment", "result", "reason", "due_ns",
                                                  "due_utc_ns")):
            said.append("slot %d: %r" % (slot["index"], o))
        flags = [f for i in slot.get("images", []) for f in i.get("flags", [])]
        if o and o["flags"] != flags:
            said.append("slot %d: flags %r, %r" % (slot["index"], o["flags"], flags))
        for image in slot.get("images", []):
            if abs(image.get("pixel_mean", 0) - image.get("mean_level", 0)) > 1e-4 and \
                    "pixel_mean" in image and "mean_level" in image:
                said.append("slot %d: mean %r" % (slot["index"], image["pixel_mean"]))
    said += ["slot %d is only ours" % i for i in ours]
    m = theirs["manifest"]
    for key in ("uuid", "simulated", "title", "source"):
        if info.get(key, m.get(key)) != m.get(key) and info.get(key) != "":
            said.append(key)
    streams = [[s[k] for k in ("id", "width", "height", "samples", "pedestal", "scale", "quantity",
                               "colour_space")] for s in m["streams"]]
    if streams != [[s[k] for k in ("id", "width", "height", "samples", "pedestal", "scale",
                                   "quantity", "colour_space")] for s in info["streams"]]:
        said.append("streams")
    if info["segments"] != len(theirs["segments"]):
        said.append("segments")
    said += ["note %r" % (n,) for n, o in zip(theirs["notes"], info["notes"]) if any(
        o.get(k, d) != n.get(k, d) for k, d in NOTE)]
    if len(theirs["notes"]) != len(info["notes"]):
        said.append("notes")
    if [[s["id"], *(s["region"][k] for k in REGION)] for s in theirs["samples"]] != [
            [s["id"], *(s[k] for k in REGION)] for s in info["samples"]]:
        said.append("samples")
    return said


NOTE = (("utc_ns", None), ("author", None), ("slots", []), ("text", ""), ("tags", []))
REGION = ("x", "y", "width", "height")
PLAN = """interval: 1min
count: 6
lamps: {mode: capture-only, settle: 5s}
shot: {lamps: {left: 100%}, brackets: [1, 4]}
"""
TINY = ["--board", "sim-small", "--set", "sim.sensor.width=96px", "--set", "sim.sensor.height=64px"]


def by_the_box(box, folder):
    """What the program itself makes: captures whole, cut short and noted on; imports, syntheses."""
    def made(*command, code=0):
        done = subprocess.run([box, *command], cwd=folder, stderr=subprocess.PIPE, check=False,
                              stdout=subprocess.DEVNULL)
        if done.returncode != code:
            sys.exit("%s: exit %d\n%s" % (command, done.returncode, done.stderr.decode()))

    os.makedirs(folder)
    write(folder + "/p.yaml", PLAN.encode())
    write(folder + "/asks", b"1 pause watering\n2 continue\n3 interval 30s\n4 note faster\n5 stop\n")
    made("calibrate", "dark", "--plan", "p.yaml", *TINY, "-o", "cal")
    made("capture", "p.yaml", *TINY, "-c", "cal", "-o", "whole")
    made("capture", "p.yaml", *TINY, "--script", "asks", "-o", "cut", code=1)
    write(folder + "/raw.yaml", PLAN.replace("[1, 4]", "[1, 4], average: 3").encode() + b"keep: both\n")
    made("capture", "raw.yaml", *TINY, "-c", "cal", "-o", "raw")
    made("capture", "p.yaml", *TINY, "-o", "faulty", "--set",
         "sim.faults=[{kind: lamp-stuck, at: 150s, target: left}, "
         "{kind: power-cut, at: 200s, for: 130s}]")
    made("note", "whole", "a \"quoted\" one", "--slots", "2-3,5", "--tag", "exclude,mine")
    made("sample", "whole", "a", "--region", "1,2,30x4", "--title", "Lolium")
    write(folder + "/pots.csv", b'id;species;x;y;width;height;treatment\r\n'
          b'b;Poa "x";0;0;96;64;"dry; ""since"" 3"\r\na;Festuca;;;;;none\r\n')
    made("sample", "whole", "--table", "pots.csv")
    made("export", "whole", "--to", "png", "--with-excluded", "-o", "pictures")
    made("export", "../made/rich", "--stream", "top", "--bracket", "1", "--role", "mask", "--to", "png", "-o", "masks")
    made("export", "../made/rich", "--stream", "top", "--role", "nonsense", "--to", "png", "-o", "none", code=2)
    made("import", *("pictures/frame.%d.png" % n for n in range(1001, 1007)), "--interval", "1min", "-o", "imported")
    made("develop", "whole", "-c", "cal", "-o", "developed")
    made("synth", "quilt", "imported", "--size", "80x70", "--block", "24x24", "-o", "grown")
    return [folder + "/" + n for n in ("whole", "raw", "cut", "faulty", "imported", "developed", "grown")]


def main():
    box, dump, folder = sys.argv[1:4]
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run([sys.executable, HERE + "/make.py", folder + "/made"], check=True)
    subprocess.run([dump, "--rich", folder + "/made/rich"], check=True, stderr=subprocess.DEVNULL)
    shutil.rmtree(folder + "/calibrations", ignore_errors=True)
    datasets = [(n, folder + "/made/" + n) for n in sorted(os.listdir(folder + "/made"))]
    for of, name, change in SPOILED:
        copy = "%s/%s-%s" % (folder, of, name)
        shutil.copytree(folder + "/made/" + of, copy)
        change(copy)
        datasets.append((of + ", " + name, copy))
    datasets += [(os.path.basename(d), d) for d in by_the_box(box, folder + "/box") + sys.argv[4:]]
    differ = 0
    for name, dataset in datasets:
        wanted = EXIT.get(name.split(", ")[-1])
        said = compare(box, dump, dataset)
        if wanted is not None and run(box, "verify", dataset)[0] != wanted:
            said.append("exit is not %d" % wanted)
        for text in said:
            differ += 1
            print("%-40s %s" % (name, text))
    print("%d datasets read twice, %d differences" % (len(datasets), differ))
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
