#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every mutation of the list fits its source: each original text occurs exactly once.

usage: mutations_apply.py ROOT
"""
import sys
from pathlib import Path

import mutation_list


def main():
    root = Path(sys.argv[1])
    try:
        mutations = mutation_list.load(root / "tests/mutate/list")
    except mutation_list.ListError as error:
        print(error)
        return 1
    wrong = mutation_list.check(mutations, root)
    wrong += mutation_list.unjudged(mutations, mutation_list.judges(root / "tests/mutate/judges.toml"))
    if wrong:
        wrong.append("Whoever changes the store changes tests/mutate/list too (tests/mutate/README.md).")
    print("\n".join(wrong + [f"{len(mutations)} mutations, {len(wrong)} that do not fit"]))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
