# SPDX-License-Identifier: Apache-2.0
"""The list of mutations (tests/mutate/list/*.toml): read, checked, applied to a text.

A mutation that no longer fits its source is an error, never skipped: so the list cannot rot.
"""
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

KEYS = {"name", "file", "breaks", "from", "to", "edits", "redundant"}


class ListError(Exception):
    """Something is wrong with the list itself; the text says where."""


@dataclass
class Mutation:
    name: str
    file: str
    breaks: str  # the promise that is broken
    edits: list = field(default_factory=list)  # (original text, replacement), each once in the file
    redundant: str = ""  # why no test can notice it, and why the code is kept all the same

    def apply(self, text):
        """The source with the mutation in it; ListError where it does not fit."""
        for original, replacement in self.edits:
            count = text.count(original)
            if count != 1:
                raise ListError(f"{self.name}: its text occurs {count} times in {self.file}, not once:\n{original}")
            text = text.replace(original, replacement)
        return text


def _one(entry, where):
    unknown = set(entry) - KEYS
    if unknown:
        raise ListError(f"{where}: unknown keys: {', '.join(sorted(unknown))}")
    for key in ("name", "file", "breaks"):
        if not isinstance(entry.get(key), str) or not entry[key].strip():
            raise ListError(f"{where}: a mutation needs a {key}")
    where = f"{where}: {entry['name']}"
    if not re.fullmatch(r"[a-z0-9-]+", entry["name"]):
        raise ListError(f"{where}: a name is of a-z, 0-9 and -")
    pairs = entry.get("edits", [])
    if ("from" in entry) == bool(pairs):
        raise ListError(f"{where}: either from and to, or edits")
    if not pairs:
        pairs = [{key: entry[key] for key in ("from", "to") if key in entry}]
    for pair in pairs:
        if set(pair) != {"from", "to"} or not pair["from"].strip():
            raise ListError(f"{where}: each edit needs from and to")
        if pair["from"] == pair["to"]:
            raise ListError(f"{where}: changes nothing")
    return Mutation(entry["name"], entry["file"], entry["breaks"],
                    [(pair["from"], pair["to"]) for pair in pairs], entry.get("redundant", ""))


def load(folder):
    """All mutations, in the order of the files' names."""
    found, names = [], set()
    for path in sorted(Path(folder).glob("*.toml")):
        try:
            table = tomllib.loads(path.read_text())
        except tomllib.TOMLDecodeError as error:
            raise ListError(f"{path.name}: {error}") from error
        if set(table) != {"mutation"}:
            raise ListError(f"{path.name}: holds [[mutation]] and nothing else")
        for entry in table["mutation"]:
            mutation = _one(entry, path.name)
            if mutation.name in names:
                raise ListError(f"{path.name}: {mutation.name} is there twice")
            names.add(mutation.name)
            found.append(mutation)
    if not found:
        raise ListError(f"{folder}: no mutations")
    return found


def check(mutations, root):
    """Applies each to the sources below root, one by one, in memory. Returns what is wrong, as texts."""
    wrong = []
    for mutation in mutations:
        path = Path(root) / mutation.file
        if not path.is_file():
            wrong.append(f"{mutation.name}: there is no {mutation.file}")
            continue
        text = path.read_text()
        try:
            if mutation.apply(text) == text:
                wrong.append(f"{mutation.name}: changes nothing")
        except ListError as error:
            wrong.append(str(error))
    return wrong


def judges(path):
    """Entries of judges.toml."""
    return tomllib.loads(Path(path).read_text())["judge"]


def unjudged(mutations, entries):
    """Mutations of which no program is asked, as texts: each would survive."""
    rooms = {room for entry in entries for room in entry["rooms"]}
    return [f"{mutation.name}: no judge looks at {mutation.file.split('/')[0]} (judges.toml)"
            for mutation in mutations if mutation.file.split("/")[0] not in rooms]
