# SPDX-License-Identifier: Apache-2.0
"""Of the second reader (read.py): lines, and what a crash leaves behind the last one."""
import re
import zlib

from reader_fields import Wrong, get, parse

CRC_END = re.compile(rb',"crc":"([0-9a-f]{8})"\}')


def crc_holds(line):
    end = CRC_END.fullmatch(line[-18:])
    return bool(end) and int(end.group(1), 16) == zlib.crc32(line[:-18])


class Lines:
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
        at = self.whole_in(tail)
        if at:
            self.find(torn, path, "the last line's LF is missing", line=number + 1)
            yield number + 1, self.line(tail[:at])
        if tail[at:]:
            self.find(torn, path, "%d bytes of a line cut off" % len(tail[at:]))

    @staticmethod
    def whole_in(text):
        """How many bytes the whole line has that the text begins with."""
        return next((m.end() for m in CRC_END.finditer(text) if crc_holds(text[:m.end()])), 0)

    @staticmethod
    def line(line):
        if not crc_holds(line):
            raise Wrong("the crc is wrong")
        o = parse(line)
        if list(o)[:2] != ["type", "seq"] or len(line) > 16 << 20:
            raise Wrong("type and seq do not come first")
        get(o, "type", "text", True)
        get(o, "seq", "int", True)
        return o
