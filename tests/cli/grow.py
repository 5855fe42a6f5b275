# SPDX-License-Identifier: Apache-2.0
"""Makes a dataset as it was, or would have been, after so many slots: files first, then the records' lines.

usage: grow.py WHOLE TO SLOTS
"""
import json
import os
import shutil
import sys


def main():
    whole, target, slots = sys.argv[1], sys.argv[2], int(sys.argv[3])
    os.makedirs(target, exist_ok=True)
    lines, paths = [], ["dataset.json"]
    for line in open(f"{whole}/records.jsonl", encoding="utf-8"):
        record = json.loads(line)
        if record["type"] == "end" or record["type"] == "slot" and record["index"] >= slots:
            break
        lines.append(line)
        paths += [file["path"] for file in record.get("files", [])]
        paths += [file["path"] for image in record.get("images", []) for file in image.get("files", [])]
    for path in paths:
        if not os.path.exists(f"{target}/{path}"):
            os.makedirs(os.path.dirname(f"{target}/{path}"), exist_ok=True)
            shutil.copy(f"{whole}/{path}", f"{target}/{path}")
    there = os.path.getsize(f"{target}/records.jsonl") if os.path.exists(f"{target}/records.jsonl") else 0
    with open(f"{target}/records.jsonl", "ab") as out:
        out.write("".join(lines).encode()[there:])


if __name__ == "__main__":
    main()
