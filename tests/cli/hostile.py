#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""hostile.py HOST:PORT/... [CASES]: malformed, oversized, slow and very many; in between, a decent client is to be served."""
import concurrent.futures
import http.client
import random
import resource
import socket
import sys
import threading

HOST, PORT = sys.argv[1].split("/")[0].rsplit(":", 1)
SEED = 20261126


def connect(patience=10, source="127.0.0.1"):
    s = socket.create_connection((HOST, int(PORT)), timeout=10, source_address=(source, 0))
    s.settimeout(patience)
    return s


def say(data, patience=10):
    """What comes back, cut; an end of the connection is an answer too."""
    s = connect(patience)
    try:
        s.sendall(data)
        s.shutdown(socket.SHUT_WR)
        return s.recv(4096)
    except OSError:
        return b""
    finally:
        s.close()


def decent():
    """From another address: one's own may have used up its share. Seconds are not looked at, only that it is served."""
    c = http.client.HTTPConnection(HOST, int(PORT), timeout=10, source_address=("127.0.0.2", 0))
    c.request("GET", "/api/v1/health")
    r = c.getresponse()
    r.read()
    c.close()
    assert r.status == 200, "a decent client got %d" % r.status


def malformed():
    texts = [
        b"", b"\r\n\r\n", b"GET\r\n\r\n", b"GET / \r\n\r\n", b"GET / HTTP/9.9\r\nHost: localhost\r\n\r\n",
        b"GET /api/v1/health HTTP/1.1\r\n\r\n", b"GET /api/v1/health HTTP/1.1\r\nHost\r\n\r\n",
        b"GET /api/v1/health HTTP/1.1\r\nHost: localhost\r\nContent-Length: -1\r\n\r\n",
        b"GET /api/v1/health HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999999999999\r\n\r\n",
        b"GET /api/v1/health HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nffffffffffffffffff\r\n",
        b"GET " + b"/a" * 50000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /api/v1/health HTTP/1.1\r\nHost: localhost\r\n" + b"X: y\r\n" * 20000 + b"\r\n",
        b"GET /api/v1/health HTTP/1.1\r\nHost: " + b"h" * 30000 + b"\r\n\r\n",
        b"GET /api/v1/datasets/%00%01%ff HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(range(256)),
    ]
    for text in texts:
        got = say(text)
        # An empty request, or one that is taken for none, gets nothing; the others nothing that looks like success.
        assert not got.startswith(b"HTTP/1.1 200"), "%r... was taken: %r" % (text[:60], got[:80])
    decent()


def noise(cases):
    chance = random.Random(SEED)
    good = b"GET /api/v1/datasets/grass/files/frames/main/000000.tif HTTP/1.1\r\nHost: localhost\r\nRange: bytes=0-9\r\n\r\n"
    texts = []
    for _ in range(cases):
        text = bytearray(good)
        for _ in range(chance.randrange(1, 6)):
            at = chance.randrange(len(text))
            if chance.random() < 0.5:
                text[at] = chance.randrange(256)
            else:
                del text[at]
        texts.append(bytes(text))
    # Half a request is waited for; not by us, and not by one after the other.
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda text: say(text, 0.2), texts))
    decent()


def begun(connections, source):
    """So many, each with half a request, held; those that the server has shut are sockets as well."""
    held = []
    for _ in range(connections):
        try:
            s = connect(source=source)
            held.append(s)
            s.sendall(b"GET /api/v1/health HTTP/1.1\r\nHo")
        except OSError:
            pass
    return held


def slow_and_many():
    """More connections than it takes from one address, each with half a request; from another address it still answers."""
    held = begun(400, "127.0.0.1")
    decent()
    for s in held:
        s.close()
    decent()


def many_from_many():
    """More than it takes in all, from eight addresses and from four hundred, and half requests that dribble on; whoever comes next is answered."""
    held = []
    for addresses, each in (8, 200), (400, 4):
        for i in range(addresses):
            held += begun(each, "127.0.%d.%d" % (1 + i // 200, 10 + i % 200))
        assert len(held) > 1000, "only %d connections" % len(held)
        decent()
    for s in held[::7]:
        try:
            s.sendall(b"s")
        except OSError:
            pass  # had to go
    for _ in range(5):
        decent()
    for s in held:
        s.close()
    decent()


def cut_off():
    """Readers that leave in the middle of an archive."""
    def one():
        try:
            s = connect()
            s.sendall(b"GET /api/v1/datasets/grass/tar HTTP/1.1\r\nHost: localhost\r\n\r\n")
            s.recv(100)
            s.close()
        except OSError:
            pass  # too many of this address
    threads = [threading.Thread(target=one) for _ in range(50)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    decent()


def main():
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(most, 8192) if most != resource.RLIM_INFINITY else 8192, most))
    malformed()
    noise(int(sys.argv[2]) if len(sys.argv) > 2 else 300)
    cut_off()
    slow_and_many()
    many_from_many()


if __name__ == "__main__":
    main()
