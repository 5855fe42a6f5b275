#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A service manager's ear: manager.py SOCKET FILE writes down each datagram, a line each, with its time."""
import os
import socket
import sys
import time

path, file = sys.argv[1:]
if os.path.exists(path):
    os.unlink(path)
ear = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
ear.bind(path)
with open(file, "a", encoding="utf-8") as out:
    print("listening", file=out, flush=True)
    while True:
        text = ear.recv(4096).decode()
        print(f"{time.monotonic():.3f} {text.replace(chr(10), ' | ')}", file=out, flush=True)
