#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bad_wire.py HOST:PORT SEED [flip]: stands between a client and a box, says where it listens, and cuts each connection after a
random number of bytes; with flip, turns over a bit of an answer's body now and then instead."""
import random
import socket
import sys
import threading

HOST, PORT = sys.argv[1].rsplit(":", 1)
CHANCE = random.Random(int(sys.argv[2]))
FLIP = len(sys.argv) > 3
LOCK = threading.Lock()


def forward(source, sink):
    try:
        while True:
            data = source.recv(65536)
            if not data:
                break
            sink.sendall(data)
    except OSError:
        pass
    for s in (source, sink):
        try:
            s.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass


def spoil(client, box):
    """Answers, cut or with a wrong bit. What is asked for goes through another thread."""
    with LOCK:
        left = CHANCE.randrange(200, 120000)
    try:
        while left > 0:
            data = bytearray(box.recv(min(left, 65536)))
            if not data:
                break
            left -= len(data)
            with LOCK:
                # Bytes of headers are let through whole: a wrong bit there is another matter.
                if FLIP and b"HTTP/1.1" not in data and CHANCE.random() < 0.1:
                    at = CHANCE.randrange(len(data))
                    data[at] ^= 1 << CHANCE.randrange(8)
            client.sendall(data)
            if FLIP:
                left = 1 << 30
    except OSError:
        pass
    for s in (client, box):
        try:
            s.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        s.close()


def main():
    door = socket.create_server(("127.0.0.1", 0))
    print("127.0.0.1:%d" % door.getsockname()[1], flush=True)
    while True:
        client, _ = door.accept()
        box = socket.create_connection((HOST, int(PORT)))
        threading.Thread(target=forward, args=(client, box), daemon=True).start()
        threading.Thread(target=spoil, args=(client, box), daemon=True).start()


if __name__ == "__main__":
    main()
