# SPDX-License-Identifier: Apache-2.0
"""Of the second reader (read.py): the files that lie there, SHA256SUMS and the seal."""
import hashlib
import os
import re

from reader_fields import NAME, good_path

SUM = re.compile(rb"([0-9a-f]{64})  (.+)")
HOLE = "bytes that did not reach the disk"
UNSEALED = ("SHA256SUMS", "notes.jsonl", "samples.json", "report.json")


def a_bit_apart(a, b):
    return len(a) == len(b) and sum(bin(x ^ y).count("1") for x, y in zip(a, b)) == 1


class Files:
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
            pair = (m.group(2).decode(errors="replace"), m.group(1).decode()) if m and not zeros else None
            pairs.append(pair if pair and (self.sealed or good_path(pair[0])) else HOLE if hole else line)
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
        if tail or any(not isinstance(x, tuple) for x in listed):
            self.find("damage", "SHA256SUMS", "is not as the seal has it")
        if not self.ended:
            self.find("damage", "records.jsonl", "the dataset is sealed and has not ended")
        if self.rehearsal:
            self.find("damage", "dataset.json", "a rehearsal is sealed")
        listed = [x for x in listed if isinstance(x, tuple)]
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
            elif isinstance(pair, bytes):
                behind = True
                if self.has_a_wrong_bit(pair):
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

    def has_a_wrong_bit(self, line):
        """Of a line of the list, or of the LF between two."""
        due = [("%s  %s" % (f["sha256"], path)).encode() for path, (f, _) in self.named.items()]
        return any(a_bit_apart(line, d) or len(line) > len(d) + 66 and line.startswith(d) and
                   a_bit_apart(line[len(d):len(d) + 1], b"\n") for d in due)

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
