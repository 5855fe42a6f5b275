# SPDX-License-Identifier: Apache-2.0
"""Of the second reader (read.py): dataset.json."""
import re

from reader_fields import HEX64, Refused, Wrong, get, id_of, parse, present, text_of
from reader_pictures import FORMATS

UUID = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")


class Manifest:
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
