# SPDX-License-Identifier: Apache-2.0
"""Who is told: writes a line "SECONDS METHOD PATH BODY" for each request. /hang never answers, /no answers 500.

usage: alerts_receiver.py LOG   (its port is its first line of output)
"""
import http.server
import sys
import threading
import time

LOCK = threading.Lock()


class Receiver(http.server.BaseHTTPRequestHandler):
    def told(self):
        body = self.rfile.read(int(self.headers.get("Content-Length", 0))).decode()
        with LOCK, open(sys.argv[1], "a", encoding="utf-8") as log:
            log.write(f"{time.time():.3f} {self.command} {self.path} {body}\n")
        if self.path.startswith("/hang"):
            time.sleep(1000)
        self.send_response(500 if self.path.startswith("/no") else 200)
        self.send_header("Content-Length", "0")
        self.end_headers()

    do_GET = do_POST = told

    def log_message(self, *_):
        pass


def main():
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Receiver)
    server.daemon_threads = True
    print(server.server_address[1], flush=True)
    server.serve_forever()


if __name__ == "__main__":
    main()
