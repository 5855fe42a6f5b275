#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads a dataset, from dataset/FORMAT.md alone: an independent reader.

    read.py DATASET      prints everything that is in it as one JSON object

Exit: 0, 3 if something is damaged, 1 if it is no dataset that this reader may read.
It shares no code with the project, so that two readers must agree on what the document says.
"""
import hashlib
import json
import os
import sys

from reader_fields import Refused, present
from reader_files import SUM, Files
from reader_lines import Lines
from reader_manifest import Manifest
from reader_people import People
from reader_pictures import picture_of, raw_of, tiff_mean
from reader_records import Records

PICTURES = ("developed", "uncertainty", "mask")  # roles


class Reader(Manifest, Lines, Records, Files, People):
    """reader_*.py have the subjects."""

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

    def summary(self):
        self.sealed = True  # until that is known
        listed, tail = self.sums()
        self.sealed = any(isinstance(x, tuple) and x[0] == "records.jsonl" for x in listed) or bool(
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
