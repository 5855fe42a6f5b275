#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails when an #include between rooms runs the wrong way, when a room reaches
into another room's private files, when the CMake table disagrees with the one
here, or when code outside hal's clocks reads time.

usage: arrows.py ROOT
"""
import re
import sys
from pathlib import Path

# The law, as ARCHITECTURE.md states it. Kept apart from cmake/Rooms.cmake on
# purpose: whoever bends one has to bend the other, in sight of a reviewer.
MAY_USE = {
    "base": set(),
    "hal": {"base"},
    "hal_sim": {"base", "hal"},
    "hal_gpiod": {"base", "hal"},
    "hal_v4l2": {"base", "hal"},
    "hal_libcamera": {"base", "hal"},
    "dataset": {"base"},
    "capture": {"base", "hal", "dataset"},
    "synth": {"base", "dataset"},
    "config": {"base", "hal", "hal_sim", "hal_v4l2", "hal_libcamera", "dataset", "capture", "synth"},
    "http": {"base", "hal", "dataset"},
    "pull": {"base", "hal", "dataset"},
    "firmware": {"base", "hal", "hal_sim", "hal_gpiod", "hal_v4l2", "hal_libcamera", "dataset", "capture", "synth", "config",
                 "http", "pull", "view", "usb", "usb_libusb"},
    "view": {"base", "dataset"},
    "usb": {"base", "hal"},
    "usb_libusb": {"base", "hal", "usb"},
}
# Most specific folder first.
FOLDERS = [("firmware/config", "config"), ("firmware/http", "http"),
           ("firmware/pull", "pull"), ("firmware/view", "view"), ("firmware/usb/libusb", "usb_libusb"), ("firmware/usb", "usb"), ("hal/sim", "hal_sim"),
           ("hal/gpiod", "hal_gpiod"), ("hal/v4l2", "hal_v4l2"),
           ("hal/libcamera", "hal_libcamera"), ("firmware", "firmware"),
           ("base", "base"), ("hal", "hal"), ("dataset", "dataset"), ("capture", "capture"),
           ("synth", "synth")]
# Headers of a room that lie in another room's include folder.
HEADER_ROOM = {"ttf/hal/sim.h": "hal_sim", "ttf/hal/gpiod.h": "hal_gpiod",
               "ttf/hal/v4l2.h": "hal_v4l2", "ttf/hal/libcamera.h": "hal_libcamera",
               "ttf/usb/libusb.h": "usb_libusb"}
# hal as a whole owns sim.h's contract; only these may include it.
CLOCK_FILES = re.compile(r"^hal/real/")
TIME_CALLS = re.compile(r"\b(clock_gettime|gettimeofday|nanosleep|clock_nanosleep|usleep|sleep|"
                        r"pthread_cond_timedwait|timer_create|timerfd_create|time|"
                        r"sleep_for|sleep_until|(?:steady|system|high_resolution)_clock::now)\s*\(")
COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*|\"(?:\\.|[^\"\\])*\"", re.S)


def room_of(path):
    for folder, room in FOLDERS:
        if path.startswith(folder + "/"):
            return room
    return None


def check_include(root, path, room, line_no, name, quoted, complain):
    if name.startswith("ttf/"):
        target = HEADER_ROOM.get(name, name.split("/")[1])
        if target not in MAY_USE:
            complain(path, line_no, f"includes {name}, of no known room")
        elif target != room and target not in MAY_USE[room]:
            # hal's own box of devices may name the simulated box's contract nowhere
            complain(path, line_no, f"room {room} includes {name} of room {target}: arrows run only downward")
    elif quoted:
        here = (root / path).parent / name
        resolved = None
        for candidate in (here, root / folder_of(room) / name):
            if candidate.exists():
                resolved = candidate.resolve().relative_to(root.resolve()).as_posix()
                break
        if resolved and room_of(resolved) != room:
            complain(path, line_no, f"room {room} includes the private file {resolved}")


def folder_of(room):
    return next(folder for folder, name in FOLDERS if name == room)


def check_sources(root, complain):
    count = 0
    for folder in ("base", "hal", "dataset", "capture", "synth", "firmware"):
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in (".c", ".h", ".cpp", ".hpp"):
                continue
            count += 1
            path = file.relative_to(root).as_posix()
            room = room_of(path)
            if path.startswith("hal/include/"):
                room = HEADER_ROOM.get(path[len("hal/include/"):], room)
            text = file.read_text(encoding="utf-8")
            for number, line in enumerate(text.splitlines(), 1):
                m = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
                if m:
                    check_include(root, path, room, number, m.group(2), m.group(1) == '"', complain)
            if not CLOCK_FILES.match(path):
                bare = COMMENT.sub(lambda c: re.sub(r"[^\n]", " ", c.group(0)), text)
                for m in TIME_CALLS.finditer(bare):
                    before = bare[:m.start()].rstrip()
                    if before.endswith(("->", ".")):
                        continue
                    complain(path, bare.count("\n", 0, m.start()) + 1,
                             f"reads or waits for time by {m.group(1)}(): time comes only from the HAL clock")
    return count


def check_table(root, complain):
    text = (root / "cmake/Rooms.cmake").read_text(encoding="utf-8")
    stated = {m.group(1): set(filter(None, m.group(2).split(";")))
              for m in re.finditer(r'set\(TTF_MAY_USE_(\w+) "([^"]*)"\)', text)}
    if stated != MAY_USE:
        complain("cmake/Rooms.cmake", 1, "its table of rooms differs from tests/arrows/arrows.py")


def main():
    root = Path(sys.argv[1])
    wrong = []
    def complain(path, line, text):
        wrong.append(f"{path}:{line}: {text}")
    check_table(root, complain)
    count = check_sources(root, complain)
    for w in wrong:
        print(w)
    print(f"{count} files read, {len(wrong)} wrong")
    return 1 if wrong or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
