# SPDX-License-Identifier: Apache-2.0
"""Of the second reader (read.py): what files of images say."""
import datetime
import re
import struct
import zlib
from fractions import Fraction

from reader_fields import present

FORMATS = {"u8": "B", "u16": "H", "f16": "e", "f32": "f"}
SAMPLE_BITS = {"u8": 8, "u16": 16, "f16": 16, "f32": 32}


def raw_of(data):
    """Size, levels, mosaic and the crc of the samples of a DNG of 16 bits in uncompressed strips."""
    tags = tiff_tags(data)
    if tags is None or tags.get(259, (1,))[0] != 1 or tags.get(258) != (16,) or 273 not in tags:
        return {}
    samples = b"".join(data[o:o + n] for o, n in zip(tags[273], tags[279]))
    cfa = tags.get(33422)
    return {"width": tags[256][0], "height": tags[257][0], "black": tags.get(50714, (0,))[0],
            "white": tags.get(50717, (65535,))[0],
            "cfa": "".join("RGB"[c] for c in cfa) if cfa else "none", "crc": zlib.crc32(samples)}


SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 7: 1, 13: 4}  # of the kinds of values that are read


def tiff_folder(data, at):
    """The tags of one folder of a little-endian TIFF: what kind of values, and their bytes."""
    tags = {}
    for i in range(struct.unpack_from("<H", data, at)[0]):
        tag, kind, count, where = struct.unpack_from("<HHII", data, at + 2 + 12 * i)
        if kind in SIZES:
            n = count * SIZES[kind]
            start = at + 10 + 12 * i if n <= 4 else where
            tags[tag] = kind, data[start:start + n]
    return tags


def numbers(kind, value):
    """Integers; unsigned fractions exact."""
    if kind == 5:
        pairs = struct.unpack("<%dI" % (len(value) // 4), value)
        return tuple(Fraction(n, d) if d else 0 for n, d in zip(pairs[::2], pairs[1::2]))
    return struct.unpack("<%d%s" % (len(value) // SIZES[kind], {1: "B", 3: "H", 4: "I", 13: "I"}[kind]), value)


def first_folder(data):
    return tiff_folder(data, struct.unpack_from("<I", data, 4)[0]) if data[:4] == b"II*\0" else None


def tiff_tags(data):
    """The first page's tags of bytes, integers and unsigned fractions that are whole."""
    folder = first_folder(data)
    return folder and {tag: tuple(int(n) for n in numbers(kind, value))
                       for tag, (kind, value) in folder.items() if kind not in (2, 7)}


# What an image says of itself, one developed or beside it: its colours (ICC.1:2010) and when it was taken (Exif 2.31)

def curve_is_straight(data):
    """A tone curve, as ICC.1 has it in `curv` (10.5) and `para` (10.15), that changes nothing."""
    kind, n = data[:4], struct.unpack_from(">I", data, 8)[0]
    if kind == b"curv" and n <= 1:
        return n == 0 or struct.unpack_from(">H", data, 12)[0] == 256
    if kind == b"curv":
        values = struct.unpack_from(">%dH" % n, data, 12)
        return all(abs(v - 65535 * i / (n - 1)) < 16 for i, v in enumerate(values))
    if kind == b"para":
        function = n >> 16
        gamma, *more = (v / 65536 for v in struct.unpack_from(
            ">%di" % (1, 3, 4, 5, 7)[function], data, 12))
        return gamma == 1 and function == 0 or function > 0 and gamma == 1 and more[:2] == [1, 0] and (
            function != 3 or more[2] == 1)
    return False


def profile_is_linear(data):
    """None: it is no profile, or says nothing of tone."""
    if len(data) < 132 or data[36:40] != b"acsp":
        return None
    tags = {}
    for i in range(struct.unpack_from(">I", data, 128)[0]):
        name, at, n = struct.unpack_from(">4sII", data, 132 + 12 * i)
        tags[name] = data[at:at + n]
    wanted = [b"kTRC"] if data[16:20] == b"GRAY" else [b"rTRC", b"gTRC", b"bTRC"]
    if any(w not in tags for w in wanted):
        return None
    return all(curve_is_straight(tags[w]) for w in wanted)


def text_in(folder, *tags):
    for tag in tags:
        if tag in folder and folder[tag][0] == 2:
            return folder[tag][1].split(b"\0")[0].decode("ascii", "replace")
    return None


def times_of(data, folder):
    """The start of the exposure and how long it was."""
    exif = tiff_folder(data, numbers(*folder[34665])[0]) if 34665 in folder else {}
    date = text_in(exif, 36867) or text_in(folder, 306)
    start = zone = exposure = None
    if date and (m := re.fullmatch(r"(\d{4}):(\d\d):(\d\d) (\d\d):(\d\d):(\d\d)", date)):
        year, month, day, h, minute, s = map(int, m.groups())
        days = datetime.date(year, month, day).toordinal() - datetime.date(1970, 1, 1).toordinal()
        start = (days * 86400 + h * 3600 + minute * 60 + s) * 10**9
        start += int((text_in(exif, 37521) or "").ljust(9, "0")[:9])
        offset = re.fullmatch(r"([+-])(\d\d):(\d\d)", text_in(exif, 36881, 36880) or "")
        if offset:
            zone = (int(offset[2]) * 3600 + int(offset[3]) * 60) * (-1 if offset[1] == "-" else 1)
            start -= zone * 10**9
    if 33434 in exif:
        exposure = round(numbers(*exif[33434])[0] * 10**9)
    return present(start_utc_ns=start, zone_offset_s=zone, exposure_ns=exposure)


def picture_of(data):
    """None of what is no little-endian TIFF."""
    folder = first_folder(data)
    if not folder:
        return None
    tags = tiff_tags(data)
    linear = profile_is_linear(folder[34675][1]) if 34675 in folder else None
    bits, kind = tags.get(258, (1,))[0], tags.get(339, (1,))[0]
    return {"width": tags[256][0], "height": tags[257][0], "samples": tags.get(277, (1,))[0],
            "sample_format": "f32" if kind == 3 else "u%d" % bits,
            "orientation": tags.get(274, (1,))[0], "icc": 34675 in folder,
            "linear": bits != 8 if linear is None else linear, **times_of(data, folder)}


def tiff_mean(data, stream):
    """The mean of the codes of a TIFF in strips, uncompressed or deflated; None of any other."""
    tags = tiff_tags(data)
    if tags is None:
        return None
    packed = tags.get(259, (1,))[0]
    if packed not in (1, 8) or tags.get(317, (1,))[0] != 1 or 273 not in tags:
        return None
    strips = [data[o:o + n] for o, n in zip(tags[273], tags[279])]
    pixels = b"".join(zlib.decompress(s) if packed == 8 else s for s in strips)
    n = tags[256][0] * tags[257][0] * tags.get(277, (1,))[0]
    if tags.get(258, (1,))[0] != SAMPLE_BITS[stream["sample_format"]]:
        return None
    return sum(struct.unpack_from("<%d%s" % (n, FORMATS[stream["sample_format"]]), pixels)) / n
