# SPDX-License-Identifier: Apache-2.0
"""Of the second reader (read.py): records.jsonl."""
import os

from reader_fields import HEX64, Wrong, file_of, get, id_of, present, text_of

RESULTS = ("captured", "partial", "missed", "failed", "paused", "power")


class Records:
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
            run_gaps_ns=get(o, "run_gaps_ns", "int"),
            run_doubted_ns=get(o, "run_doubted_ns", "int", False, 0) or None,
            run_given_up_ns=get(o, "run_given_up_ns", "int", False, 0) or None,
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
