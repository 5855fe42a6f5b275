# SPDX-License-Identifier: Apache-2.0
"""Of the second reader (read.py): fields of objects, checked as FORMAT.md has them."""
import json
import re

NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9._-]{0,63}")
HEX64 = re.compile(r"[0-9a-f]{64}")


class Refused(Exception):
    """No dataset, or one that must not be read."""


class Wrong(Exception):
    """A line or field is not as FORMAT.md has it."""


def is_int(v):
    return isinstance(v, int) and not isinstance(v, bool) and -2**63 <= v < 2**63


def is_number(v):
    return isinstance(v, (int, float)) and not isinstance(v, bool)


def get(o, key, kind, required=False, low=None, high=None):
    """A field of an object, checked; None where it is absent."""
    if key not in o:
        if required:
            raise Wrong("lacks " + key)
        return None
    v = o[key]
    good = {"int": is_int, "number": is_number, "text": lambda x: isinstance(x, str),
            "bool": lambda x: isinstance(x, bool), "list": lambda x: isinstance(x, list),
            "object": lambda x: isinstance(x, dict)}[kind](v)
    if not good or (low is not None and v < low) or (high is not None and v > high):
        raise Wrong("%s is wrong: %r" % (key, v))
    return v


def cut(text, limit):
    """A free text that is longer than the format gives is cut, at a whole character."""
    return None if text is None else text.encode()[:limit].decode(errors="ignore")


def text_of(o, key, limit, required=False):
    return cut(get(o, key, "text", required), limit)


def id_of(o, key, limit, required=False):
    v = get(o, key, "text", required)
    if v is not None and len(v.encode()) > limit:
        raise Wrong("%s is too long" % key)
    return v


def present(**fields):
    """What does not apply is absent."""
    return {k: v for k, v in fields.items() if v is not None}


def no_duplicates(pairs):
    if len({k for k, _ in pairs}) != len(pairs):
        raise Wrong("a key stands there twice")
    return dict(pairs)


def parse(data):
    try:
        text = data.decode("utf-8")
        o = json.loads(text, object_pairs_hook=no_duplicates)
    except ValueError as e:
        raise Wrong("no JSON: %s" % e) from None
    if not isinstance(o, dict) or "\\u0000" in text:
        raise Wrong("no JSON object as the format has it")
    return o


def good_path(path):
    return len(path.encode()) <= 191 and all(NAME.fullmatch(n) for n in path.split("/"))


def file_of(o):
    path = get(o, "path", "text", True)
    if not good_path(path):
        raise Wrong("a path leads astray: %r" % path)
    sha = get(o, "sha256", "text", True)
    if not HEX64.fullmatch(sha):
        raise Wrong("no sha256: %r" % sha)
    return {"path": path, "bytes": get(o, "bytes", "int", True, 0), "sha256": sha}
