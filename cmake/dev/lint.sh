#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Everything that is wrong without running the programs. Called by ./dev lint from the root; with
# names of files, clang-tidy (most of the time) reads those alone.
# shellcheck disable=SC2317 # the steps are called by name
set -uo pipefail
failed=0
only=("$@")
step() { # NAME COMMAND...
    local name=$1
    shift
    if "$@" >build/lint.log 2>&1; then
        echo "lint: $name: clean"
    else
        echo "lint: $name: FAILED"
        head -n 60 build/lint.log
        failed=1
    fi
}

format() { git ls-files -z '*.c' '*.h' '*.cpp' '*.hpp' | xargs -0 clang-format --style=file --dry-run -Werror; }

tidy() {
    # Each source once, with its first command: one that several tests compile would be read several
    # times, and clang-tidy 14 then finds uninitialised va_lists that are not there. What is not built here
    # (fuzz targets, the other major version of a library) has no command and is not read.
    mkdir -p build/lint
    local sources=('*.c' '*.cpp')
    [ ${#only[@]} -eq 0 ] || sources=("${only[@]}")
    # Of a finding, the line that names it: the analyzer's paths are for whoever runs it on that file.
    git ls-files -z -- "${sources[@]}" | python3 -c '
import json, os, sys
commands = {c["file"]: c for c in reversed(json.load(open("build/compile_commands.json")))}
json.dump(list(commands.values()), open("build/lint/compile_commands.json", "w"))
files = [f for f in sys.stdin.read().split("\0") if os.path.abspath(f) in commands
         and not f.startswith("tests/fuzz/")]
sys.stdout.write("\0".join(files))' |
        xargs -0 -r -n 1 -P "$(nproc)" clang-tidy -p build/lint --quiet >build/tidy.log 2>&1
    local status=$?
    grep -E '(warning|error):' build/tidy.log
    return "$status"
}

spdx() {
    local missing
    missing=$(git ls-files '*.c' '*.h' '*.cpp' '*.hpp' '*.sh' '*.py' dev | xargs grep -L 'SPDX-License-Identifier: Apache-2.0')
    [ -z "$missing" ] || { echo "without a licence line:"; echo "$missing"; return 1; }
}

sizes() { # no file near 1,000 lines, base under 400
    local bad
    bad=$(git ls-files '*.c' '*.h' '*.cpp' '*.hpp' '*.py' '*.sh' dev | xargs wc -l | awk '$2 != "total" && $1 > 900')
    [ -z "$bad" ] || { echo "too long:"; echo "$bad"; return 1; }
    local base
    base=$(cat base/*.c base/include/ttf/base/*.h | wc -l)
    [ "$base" -lt 400 ] || { echo "base/ has $base lines; it is to stay under 400"; return 1; }
}

spaces() { ! git grep -nI -E '[[:space:]]+$' -- '*.c' '*.h' '*.cpp' '*.hpp' '*.sh' '*.py' '*.cmake' '*CMakeLists.txt' dev '*.yaml'; }

# What a merge has left behind, of a file of any kind: within a text that a script prints nothing else sees it.
merges() { ! git grep -nI -E '^(<{7}|>{7})( |$)'; }

shells() { git ls-files -z '*.sh' dev .ci/run firmware/gadget/ttfbox-gadget | xargs -0 shellcheck -x -P SCRIPTDIR -P .; }

step format format
step 'licence lines' spdx
step 'file sizes' sizes
step 'trailing space' spaces
step 'merge markers' merges
step 'shell scripts' shells
step arrows python3 tests/arrows/arrows.py .
step clang-tidy tidy
exit $failed
