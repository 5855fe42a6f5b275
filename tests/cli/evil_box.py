#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""evil_box.py CASE: a box that means harm to whoever pulls from it; says where it listens."""
import http.server
import json
import sys
import zlib

CASE = sys.argv[1]
SHA = "0" * 64


def line(body):
    text = json.dumps(body, separators=(",", ":"))[:-1]
    return ('%s,"crc":"%08x"}\n' % (text, zlib.crc32(text.encode()))).encode()


def record(path, size):
    return line({"type": "slot", "seq": 0, "index": 0, "segment": 0, "due_ns": 0, "result": "captured",
                 "images": [{"stream": "main", "files": [{"role": "developed", "path": path, "bytes": size, "sha256": SHA}]}]})


RECORDS = {
    "path": record("../../../escaped", 4), "absolute": record("/tmp/escaped", 4), "long": record("frames/main/000000.tif", 10),
    "garbage": b"not a line\n" * 100, "noend": b"x" * 100, "name": b"", "size": record("frames/main/000000.tif", -5), "notes": record("notes.jsonl", 4), "hidden": record(".envrc", 4),
    "nolength": b"", "nomanifest": record("frames/main/000000.tif", 1000000), "endless": line({"type": "other", "seq": 0, "text": "x" * 9000}) * 100,
}


class Box(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def give(self, body, status=200):
        self.send_response(status)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def do_GET(self):
        path = self.path[len("/api/v1"):]
        if path == "/datasets":
            names = ["../escaped", "..", "/tmp/escaped", ".hidden", "a/b"] if CASE == "name" else ["grass"]
            self.give(json.dumps({"datasets": [{"name": n} for n in names]}).encode())
        elif path == "/datasets/grass":
            self.give(b'{"name":"grass","slots":1,"sealed":false}')
        elif path.endswith("/dataset.json") and CASE == "nomanifest":
            self.give(b'{"error":"it cannot be read"}', 500)
        elif path.endswith("/dataset.json") and CASE == "nolength":
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b'{"format":{"name":"ttf","major":1,"minor":1}}')
            self.close_connection = True
        elif path.endswith("/dataset.json"):
            self.give(b'{"format":{"name":"ttf","major":1,"minor":1}}')
        elif path.endswith("/records"):
            first = int(self.headers.get("Range", "bytes=0-")[6:].split("-")[0])
            if CASE == "endless" and first < 80 * len(RECORDS[CASE]):
                first %= len(RECORDS[CASE])
            data = RECORDS[CASE][first:]
            self.give(data, 206) if data else self.give(b"", 416)
        elif path.endswith(".tif"):
            self.give(b"y" * 1000000)
        else:
            self.give(b"{}", 404)

    def log_message(self, *_):
        pass


def main():
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Box)
    print("127.0.0.1:%d" % server.server_address[1], flush=True)
    server.serve_forever()


if __name__ == "__main__":
    main()
