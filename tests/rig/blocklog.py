# SPDX-License-Identifier: Apache-2.0
"""The log of what a disk was told, as qemu's blklogwrites filter writes it (the format of Linux's dm-log-writes), and
the disks that a power cut could have left: all that a flush had confirmed, and of the rest what chance decides."""
import os
import struct

MAGIC = 0x6A736677736872
FLUSH, FUA, DISCARD, MARK = 1, 2, 4, 8
SECTOR = 512


class Entry:
    def __init__(self, at, size, flags, data, end):
        self.at, self.size, self.flags, self.data = at, size, flags, data
        self.end = end  # where the log went on behind it, in bytes

    def put(self, disk, pieces=None, whole=SECTOR):
        """Onto a bytearray: all of it, or only these of its pieces of so many bytes (a torn write)."""
        data = bytes(self.size) if self.flags & DISCARD else self.data
        if pieces is None:
            disk[self.at:self.at + len(data)] = data
            return
        for p in pieces:
            piece = data[p * whole:(p + 1) * whole]
            disk[self.at + p * whole:self.at + p * whole + len(piece)] = piece


def read(path):
    """All entries. The count in the log's head lags behind, so its length tells where it ends."""
    entries = []
    length = os.path.getsize(path)
    with open(path, "rb") as f:
        magic, version, _, unit = struct.unpack("<QQQI", f.read(28))
        if magic != MAGIC or version != 1:
            raise RuntimeError("%s is no log of a disk" % path)
        pos = unit
        while pos + unit <= length:
            f.seek(pos)
            sector, n, flags, extra = struct.unpack("<QQQQ", f.read(32))
            pos += unit
            data = b""
            if flags & MARK:
                pos += (extra + unit - 1) // unit * unit
            elif n and not flags & DISCARD:
                f.seek(pos)
                data = f.read(n * unit)
                if len(data) < n * unit:
                    break
                pos += n * unit
            if n == 0 and flags == 0:
                break
            entries.append(Entry(sector * unit, n * unit, flags, data, pos))
    return entries


class Replay:
    """A disk that goes through a log: `disk` is what is certain, `waiting` what no flush has confirmed yet."""

    def __init__(self, image, entries):
        with open(image, "rb") as f:
            self.disk = bytearray(f.read())
        self.entries, self.next, self.waiting = entries, 0, []

    def to(self, until):
        """Takes entries up to this one (not with it)."""
        while self.next < until:
            entry = self.entries[self.next]
            self.next += 1
            if entry.flags & FLUSH:
                for w in self.waiting:
                    w.put(self.disk)
                self.waiting = []
            if entry.size and entry.flags & FUA:
                self.overtake(entry)
                entry.put(self.disk)
            elif entry.size:
                self.waiting.append(entry)

    def overtake(self, entry):
        """A write that is certain at once: what it overwrites must have been there before it, or never come."""
        apart = []
        for w in self.waiting:
            if w.at + w.size <= entry.at or w.at >= entry.at + entry.size:
                apart.append(w)
            else:
                w.put(self.disk)
        self.waiting = apart

    def cut(self, chance, whole=SECTOR):
        """What a cut may leave: each write there, gone or torn, in whatever order; the disk writes so many bytes whole.
        (disk, how many of each)."""
        disk = bytearray(self.disk)
        order = list(self.waiting)
        keep = chance.random()  # now and then nearly all, now and then hardly any
        if chance.random() < 0.5:
            chance.shuffle(order)
        counts = {"kept": 0, "dropped": 0, "torn": 0}
        for w in order:
            n = -(-w.size // whole)
            if chance.random() < keep:
                w.put(disk)
                counts["kept"] += 1
            elif n > 1 and chance.random() < 0.5:
                w.put(disk, self.torn(chance, n), whole)
                counts["torn"] += 1
            else:
                counts["dropped"] += 1
        return disk, counts

    @staticmethod
    def torn(chance, n):
        """Its first pieces, or any of them."""
        if chance.random() < 0.5:
            return range(chance.randrange(1, n))
        return [p for p in range(n) if chance.random() < 0.5]
