#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""short_box.py HOST:PORT PATH TIMES: stands before a box that is short of handles: a file's first so many requests (0: all of them) are answered
503. Says where it listens."""
import http.client
import http.server
import sys
import threading

HOST, PORT = sys.argv[1].rsplit(":", 1)
PATH, TIMES = sys.argv[2], int(sys.argv[3])
LOCK = threading.Lock()
asked = 0


def is_short(path):
    global asked
    if not path.endswith(PATH):
        return False
    with LOCK:
        asked += 1
        return TIMES == 0 or asked <= TIMES


class Box(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def do_GET(self):
        if is_short(self.path):
            self.give(503, [], b'{"error":"too many open files"}')
            return
        c = http.client.HTTPConnection(HOST, int(PORT), timeout=10)
        c.request("GET", self.path, headers={k: v for k, v in self.headers.items() if k in ("Range", "If-Range")})
        r = c.getresponse()
        self.give(r.status, [(k, v) for k, v in r.getheaders() if k in ("ETag", "Content-Range")], r.read())
        c.close()

    def give(self, status, headers, body):
        self.send_response(status)
        for header in headers:
            self.send_header(*header)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Box)
print("127.0.0.1:%d" % server.server_address[1], flush=True)
server.serve_forever()
