# SPDX-License-Identifier: Apache-2.0
"""What raw files of 8-bit RGB frames show, and pictures to control syntheses with.

frames.py picture KIND OUT W H    halves (left black, right white), hill (heights), tilt (normals),
                                  photo (a red object and its shadow on a grey ground), plain
frames.py nudged FOLDER N W H      a still texture whose frames are moved and lit unevenly
frames.py noise FOLDER N W H       noise, another in each frame
frames.py pngs FOLDER OUT         exported PNGs, one behind another
frames.py edges RAW W H           step across the edges over the mean step inside, last frame
frames.py slope RAW W H           mean red of the right quarter less that of the left, frame 0
frames.py moved RAW W H X0 X1     mean difference of the first and last frame, columns X0..X1-1
frames.py mean RAW W H X Y R T    "R G B" around a place in frame T (negative: from the end)
"""
import glob
import random
import sys

import pictures


def colour(kind, x, y, w, h):
    if kind == "halves":
        return (255, 255, 255) if x >= w // 2 else (0, 0, 0)
    if kind == "hill":
        v = max(0, int(255 - 900 * ((x / w - 0.5) ** 2 + (y / h - 0.5) ** 2)))
        return (v, v, v)
    if kind == "tilt":
        return (128, 128, 255) if x < w // 2 else (255, 128, 128)
    if kind == "photo" and w // 4 <= x < w // 2 and h // 4 <= y < h // 2:
        return (190, 40, 30)
    if kind == "photo" and w // 4 <= x < 3 * w // 4 and h // 2 <= y < 3 * h // 4:
        return (81, 81, 80)
    return (180, 180, 178)


def picture(kind, out, w, h):
    pictures.write_png(out, w, h, [bytes(v for x in range(w) for v in colour(kind, x, y, w, h))
                                   for y in range(h)])


def nudged(folder, n, w, h):
    def level(x, y):
        return ((x // 5 * 7919 + y // 5 * 104729) * 2654435761 >> 8) % 120 + 60
    for t in range(n):
        dx, gain = (2 if t % 5 == 3 else 0), (1.1 if t % 4 == 1 else 1.0)
        rows = [bytes(int(level(x + dx, y) * gain) for x in range(w) for _ in range(3)) for y in range(h)]
        pictures.write_png(f"{folder}/n{t}.png", w, h, rows)


def noise(folder, n, w, h):
    for t in range(n):
        draw = random.Random(t)
        rows = [draw.randbytes(3 * w) for _ in range(h)]
        pictures.write_png(f"{folder}/n{t}.png", w, h, rows)


def frames(path, w, h):
    data = open(path, "rb").read()
    size = w * h * 3
    assert len(data) % size == 0, (path, len(data), size)
    return [data[i:i + size] for i in range(0, len(data), size)]


def steps(frame, pairs):
    total = [abs(frame[a + c] - frame[b + c]) for a, b in pairs for c in range(3)]
    return sum(total) / len(total)


def edges(path, w, h):
    f = frames(path, w, h)[-1]
    across = steps(f, [((y * w + w - 1) * 3, y * w * 3) for y in range(h)])
    down = steps(f, [(((h - 1) * w + x) * 3, x * 3) for x in range(w)])
    inside = steps(f, [((y * w + x) * 3, (y * w + x + 1) * 3) for y in range(h) for x in range(w - 1)])
    return max(across, down) / inside


def red(frame, w, h, x0, x1):
    return sum(frame[(y * w + x) * 3] for y in range(h) for x in range(x0, x1)) / (h * (x1 - x0))


def slope(path, w, h):
    f = frames(path, w, h)[0]
    return red(f, w, h, w - w // 4, w) - red(f, w, h, 0, w // 4)


def moved(path, w, h, x0, x1):
    all_frames = frames(path, w, h)
    a, b = all_frames[0], all_frames[-1]
    places = [(y * w + x) * 3 + c for y in range(h) for x in range(x0, x1) for c in range(3)]
    return sum(abs(a[i] - b[i]) for i in places) / len(places)


def mean(path, w, h, x, y, r, t):
    f = frames(path, w, h)[t]
    places = [((yy * w) + xx) * 3 for yy in range(y - r, y + r + 1) for xx in range(x - r, x + r + 1)]
    return " ".join(str(round(sum(f[i + c] for i in places) / len(places))) for c in range(3))


def pngs(folder, out):
    with open(out, "wb") as f:
        for path in sorted(glob.glob(f"{folder}/*.png")):
            f.write(b"".join(pictures.read_png(path)[3]))


command, args = sys.argv[1], sys.argv[2:]
if command == "picture":
    picture(args[0], args[1], int(args[2]), int(args[3]))
elif command == "nudged":
    nudged(args[0], *map(int, args[1:]))
elif command == "noise":
    noise(args[0], *map(int, args[1:]))
elif command == "pngs":
    pngs(*args)
else:
    result = {"edges": edges, "slope": slope, "moved": moved, "mean": mean}[command](
        args[0], *map(int, args[1:]))
    print(result if isinstance(result, str) else f"{result:.4f}")
