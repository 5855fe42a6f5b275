#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""one_answer.py HOST:PORT PATH cut|flip BYTES: stands before a box, says where it listens, and spoils the first answer to a request whose path ends
in PATH: it ends after so many bytes, its head included, or a bit of that byte of its body is another. All else goes through."""
import socket
import sys
import threading

HOST, PORT = sys.argv[1].rsplit(":", 1)
PATH, KIND, BYTES = sys.argv[2].encode(), sys.argv[3], int(sys.argv[4])
LOCK = threading.Lock()
done = False


def is_the_one(request):
    global done
    with LOCK:
        if done or not request.split(b" ")[1].endswith(PATH):
            return False
        done = True
        return True


def end(*sockets):
    for s in sockets:
        try:
            s.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass


def ask(client, box, chosen):
    try:
        while request := client.recv(65536):
            if is_the_one(request):
                chosen.set()
            box.sendall(request)
    except OSError:
        pass
    end(client, box)


def spoilt(whole, n):
    """What of the answer's first so many bytes goes on now, of which the last n are new; None: nothing more."""
    head = whole.find(b"\r\n\r\n") + 4
    at = BYTES if KIND == "cut" else head + BYTES
    if KIND == "cut":
        return whole[len(whole) - n:at] if at > len(whole) - n else None
    if head >= 4 and len(whole) - n <= at < len(whole):
        whole[at] ^= 1
    return whole[len(whole) - n:]


def answer(box, client, chosen):
    whole = bytearray()
    try:
        while data := box.recv(65536):
            if chosen.is_set():
                whole += data
                data = spoilt(whole, len(data))
                if data is None:
                    break
            client.sendall(data)
            if KIND == "cut" and len(whole) >= BYTES:
                break
    except OSError:
        pass
    end(client, box)


def main():
    door = socket.create_server(("127.0.0.1", 0))
    print("127.0.0.1:%d" % door.getsockname()[1], flush=True)
    while True:
        client, _ = door.accept()
        box = socket.create_connection((HOST, int(PORT)))
        chosen = threading.Event()
        threading.Thread(target=ask, args=(client, box, chosen), daemon=True).start()
        threading.Thread(target=answer, args=(box, client, chosen), daemon=True).start()


if __name__ == "__main__":
    main()
