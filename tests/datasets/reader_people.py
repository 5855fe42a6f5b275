# SPDX-License-Identifier: Apache-2.0
"""Of the second reader (read.py): notes and samples, which people write."""
from reader_fields import Wrong, get, id_of, parse, present, text_of


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


class People:
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
