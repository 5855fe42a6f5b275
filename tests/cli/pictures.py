# SPDX-License-Identifier: Apache-2.0
"""Pictures and arrays for the scripts here, with the standard library alone.

pictures.py make FOLDER N W H     N sRGB PNGs: a smooth ground on which patches grow
pictures.py same A B              two PNGs have the same pixels
pictures.py mae A.npy B.npy       mean absolute difference of two arrays, of full scale,
                                  frame by frame: the greatest
"""
import array
import ast
import struct
import sys
import zlib


def write_png(path, w, h, rows):
    raw = b"".join(b"\0" + row for row in rows)

    def chunk(name, data):
        return (struct.pack(">I", len(data)) + name + data +
                struct.pack(">I", zlib.crc32(name + data)))
    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", w, h, 8, 2, 0, 0, 0)) +
                chunk(b"IDAT", zlib.compress(raw, 6)) + chunk(b"IEND", b""))


def read_png(path):
    data = open(path, "rb").read()
    pos, idat = 8, b""
    while pos < len(data):
        n, name = struct.unpack(">I4s", data[pos:pos + 8])
        body = data[pos + 8:pos + 8 + n]
        if name == b"IHDR":
            w, h, bits, kind = struct.unpack(">IIBB", body[:10])
        elif name == b"IDAT":
            idat += body
        pos += 12 + n
    bpp = {0: 1, 2: 3, 4: 2, 6: 4}[kind] * bits // 8
    raw, stride = zlib.decompress(idat), w * bpp
    rows, before = [], bytearray(stride)
    for y in range(h):
        kind_of_filter = raw[y * (stride + 1)]
        row = bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            a = row[i - bpp] if i >= bpp else 0
            b, c = before[i], before[i - bpp] if i >= bpp else 0
            if kind_of_filter == 1:
                row[i] = (row[i] + a) & 255
            elif kind_of_filter == 2:
                row[i] = (row[i] + b) & 255
            elif kind_of_filter == 3:
                row[i] = (row[i] + (a + b) // 2) & 255
            elif kind_of_filter == 4:
                p = a + b - c
                best = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))
                row[i] = (row[i] + best[2]) & 255
        rows.append(bytes(row))
        before = row
    return w, h, bpp, rows


def make(folder, n, w, h):
    state = 12345
    patches = []
    for _ in range(24):
        state = (state * 1103515245 + 12345) & 0x7fffffff
        patches.append((state % w, state // 7 % h, 2 + state // 101 % 9, state // 1009 % n))
    for t in range(n):
        rows = []
        for y in range(h):
            row = bytearray()
            for x in range(w):
                rgb = [90 + 60 * x // w, 80 + 50 * y // h, 60 + (x * 7 + y * 13) % 11]
                for px, py, r, born in patches:
                    if t > born and (x - px) ** 2 + (y - py) ** 2 < r * r * (t - born) / n * 4:
                        rgb = [40, 170 - 2 * r, 70]
                row += bytes(rgb)
            rows.append(bytes(row))
        write_png(f"{folder}/p{t}.png", w, h, rows)


def read_npy(path):
    with open(path, "rb") as f:
        assert f.read(6) == b"\x93NUMPY"
        major = f.read(2)[0]
        size = struct.unpack("<H" if major == 1 else "<I", f.read(2 if major == 1 else 4))[0]
        head = ast.literal_eval(f.read(size).decode())
        assert head["descr"] == "<u2" and not head["fortran_order"], head
        values = array.array("H")
        values.frombytes(f.read())
    return head["shape"], values


def mae(a, b):
    (shape_a, va), (shape_b, vb) = read_npy(a), read_npy(b)
    assert shape_a == shape_b, (shape_a, shape_b)
    n = len(va) // shape_a[0]
    return max(sum(abs(p - q) for p, q in zip(va[t * n:(t + 1) * n], vb[t * n:(t + 1) * n])) / n
               for t in range(shape_a[0])) / 65535


if __name__ == "__main__":
    if sys.argv[1] == "make":
        make(sys.argv[2], *map(int, sys.argv[3:6]))
    elif sys.argv[1] == "same":
        sys.exit(read_png(sys.argv[2]) != read_png(sys.argv[3]))
    elif sys.argv[1] == "mae":
        print(f"{mae(sys.argv[2], sys.argv[3]):.6f}")
