#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
ask_name.py ADDRESS NAME [plain | noise | alone BOX | often BOX | other BOX]: asks all on the network of this machine's ADDRESS for a name by multicast DNS (RFC 6762), as its own
questions are asked or (plain) from any port, as nslookup does; prints "ADDRESS from ADDRESS", or nothing within half a second.
noise: sends some thousand broken datagrams first, and a question behind them, which is to be answered.
alone: asks not all, but the box's address, from this machine's ADDRESS.
other: asks all, a second after anything else, for the name's IPv6 address, knowing its IPv4 one, BOX; and at once, as somebody else would, for that.
often: the box's address alone, 200 times at once; prints how many answers came within 0.8 s of the first.
"""
import random
import socket
import struct
import sys
import time

GROUP, PORT = "224.0.0.251", 5353
HERE, NAME = sys.argv[1:3]
HOW = sys.argv[3] if len(sys.argv) > 3 else ""
TO = (sys.argv[4] if HOW in ("alone", "often") else GROUP, PORT)


def encoded(name):
    return b"".join(bytes([len(part)]) + part.encode() for part in name.split(".")) + b"\0"


QUESTION = struct.pack(">HHHHHH", 7, 0, 1, 0, 0, 0) + encoded(NAME) + struct.pack(">HH", 1, 1)


def opened():
    s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    if HOW in ("alone", "often"):
        s.bind((HERE, 0))
        return s
    if HOW != "plain":
        s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        s.bind(("", PORT))
        s.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(GROUP) + socket.inet_aton(HERE))
    s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(HERE))
    s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 0)
    return s


def answer(s, patience):
    """The address of an A record of this name, and who says so."""
    until = time.monotonic() + patience
    while (left := until - time.monotonic()) > 0:
        s.settimeout(left)
        try:
            data, (who, _) = s.recvfrom(9000)
        except TimeoutError:
            break
        flags, questions, answers = struct.unpack(">HHH", data[2:8])
        if not flags & 0x8000 or answers < 1:
            continue
        at = 12 + (len(QUESTION) - 12 if questions else 0)
        at += 2 if data[at] & 0xC0 == 0xC0 else len(encoded(NAME))
        kind, _, ttl, n = struct.unpack(">HHIH", data[at:at + 10])
        if kind == 1 and n == 4 and ttl > 0 and encoded(NAME) in data:
            return "%s from %s" % (socket.inet_ntoa(data[at + 10:at + 14]), who)
    return ""


def often(s):
    for _ in range(200):
        s.sendto(QUESTION, TO)
    answers, patience = 0, 3.0
    while patience > 0:
        begun = time.monotonic()
        if not answer(s, patience):
            break
        patience = patience - (time.monotonic() - begun) if answers else 0.8
        answers += 1
    return answers


def main():
    s = opened()
    if HOW == "often":
        print(often(s))
        return
    if HOW == "noise":
        chance = random.Random(20261127)
        for _ in range(3000):
            text = bytearray(QUESTION)
            for _ in range(chance.randrange(1, 5)):
                text[chance.randrange(len(text))] = chance.randrange(256)
            s.sendto(text[:chance.randrange(1, len(text) + 1)], (GROUP, PORT))
        time.sleep(2)
    if HOW == "other":
        time.sleep(1.2)
        known = b"\xc0\x0c" + struct.pack(">HHIH", 1, 1, 120, 4) + socket.inet_aton(sys.argv[4])
        s.sendto(struct.pack(">HHHHHH", 7, 0, 1, 1, 0, 0) + encoded(NAME) + struct.pack(">HH", 28, 1) + known, TO)
        s.sendto(QUESTION, TO)
        print(answer(s, 0.6))
        return
    for _ in range(3):  # told to all a moment ago, it is not told again within a second
        s.sendto(QUESTION, TO)
        got = answer(s, 0.5)
        if got:
            print(got)
            sys.exit(0)
    sys.exit(1 if HOW == "noise" else 0)


main()
