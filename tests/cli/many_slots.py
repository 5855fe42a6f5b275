# SPDX-License-Identifier: Apache-2.0
"""Makes a dataset of many slots out of one with a few: the same records over and over, without their files.

usage: many_slots.py FROM TO SLOTS [--files] [--missed N]   (slot 7777 has a mean level of 0.875)
--files: with the one frame that all of them name; --missed: of each 16 slots the first N were missed
"""
import json
import os
import shutil
import sys
import zlib


def line(record):
    record.pop("crc", None)
    body = json.dumps(record, separators=(",", ":"))[:-1]
    return f'{body},"crc":"{zlib.crc32(body.encode()):08x}"}}\n'


def main():
    source, target, slots = sys.argv[1], sys.argv[2], int(sys.argv[3])
    missed = int(sys.argv[sys.argv.index("--missed") + 1]) if "--missed" in sys.argv else 0
    os.makedirs(target)
    shutil.copy(f"{source}/dataset.json", target)
    records = [json.loads(text) for text in open(f"{source}/records.jsonl", encoding="utf-8")]
    head = [r for r in records if r["type"] != "slot" and r["type"] != "end"]
    slot = next(r for r in records if r["type"] == "slot")
    interval = next(r["interval_ns"] for r in head if r["type"] == "segment")
    for file in slot["images"][0]["files"] if "--files" in sys.argv else []:
        os.makedirs(os.path.dirname(f"{target}/{file['path']}"), exist_ok=True)
        shutil.copy(f"{source}/{file['path']}", f"{target}/{file['path']}")
    due, middle, level = slot["due_ns"], slot["middle_ns"], slot["images"][0]["mean_level"]
    with open(f"{target}/records.jsonl", "w", encoding="utf-8") as out:
        for seq, record in enumerate(head):
            record["seq"] = seq
            out.write(line(record))
        for i in range(slots):
            slot["seq"], slot["index"] = len(head) + i, i
            slot["due_ns"], slot["middle_ns"] = due + i * interval, middle + i * interval
            slot["images"][0]["mean_level"] = 0.875 if i == 7777 else level
            if i % 16 < missed:
                out.write(line({"type": "slot", "seq": slot["seq"], "index": i, "segment": slot["segment"], "due_ns": slot["due_ns"],
                                "result": "missed", "why": "storage too slow"}))
            else:
                out.write(line(slot))


if __name__ == "__main__":
    main()
