#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs fuzz targets that are built: fuzz.sh TARGET SECONDS, fuzz.sh all SECONDS, or fuzz.sh until SECONDS [TARGET...]. Called by
# ./dev fuzz from the root. What a target learns stays in build-fuzz/corpus, an input that fails in build-fuzz/found.
set -uo pipefail

# TARGET SECONDS: the fuzzer itself, in place of this shell.
run() {
    mkdir -p "build-fuzz/corpus/$1" build-fuzz/found build-fuzz/dictionaries
    python3 tests/fuzz/dictionary.py "$1" >"build-fuzz/dictionaries/$1" || exit 1
    local longest=16384 # of an input, in bytes
    case $1 in tiff | dng | png | jpeg) longest=65536 ;; esac
    # A small quarantine that keeps its pages: giving them back is most of what short runs cost.
    export ASAN_OPTIONS=quarantine_size_mb=16:allocator_release_to_os_interval_ms=-1:malloc_context_size=8
    UBSAN_OPTIONS=print_stacktrace=1 exec "build-fuzz/tests/fuzz/fuzz_$1" \
        -max_total_time="$2" -max_len="$longest" -dict="build-fuzz/dictionaries/$1" -detect_leaks=1 \
        -timeout=20 -report_slow_units=20 -rss_limit_mb=3000 -print_final_stats=1 -artifact_prefix="build-fuzz/found/$1-" \
        "build-fuzz/corpus/$1" "tests/fuzz/seeds/$1"
}

# How many inputs of a kind a target has left since the campaign began.
found() { # TARGET KIND...
    local target=$1 n=0 kind
    shift
    for kind in "$@"; do
        n=$((n + $(find build-fuzz/found -name "$target-$kind-*" -newer build-fuzz/campaign | wc -l)))
    done
    echo "$n"
}

# One target with a line for the summary, and one in build-fuzz/spent; its whole output in build-fuzz/log.
measured() {
    local log=build-fuzz/log/$1 cpu status executions edges
    TIMEFORMAT='%U %S'
    # (The output is sent away inside: of the last command of all, "time" itself would write to the log. And the target
    # is not the last thing that is timed: in the timed shell's own place it would leave nobody to print the time.)
    cpu=$({ time { (run "$1" "$2" >"$log" 2>&1); status=$?; }; exit "$status"; } 2>&1) && status=0 || status=$?
    echo "$1 $cpu" >>build-fuzz/spent
    executions=$(sed -n 's/^stat::number_of_executed_units: //p' "$log")
    edges=$(grep -ao 'cov: [0-9]*' "$log" | tail -n 1)
    printf '%-12s %10.0f %12s %8s %8d %6d %9d   %s\n' "$1" "$(awk '{ print $1 + $2 }' <<<"$cpu")" \
        "${executions:-0}" "${edges#cov: }" "$(found "$1" crash oom)" "$(found "$1" leak)" \
        "$(found "$1" timeout)" "$([ "$status" -eq 0 ] && echo clean || echo "FAILED: $log")"
    return "$status"
}

# Each of the targets, the one with the least CPU time first, that has not had SECONDS of it yet: "SPENT TARGET".
lacking() { # SECONDS TARGET...
    printf '%s\n' "${@:2}" |
        awk -v wanted="$1" 'FILENAME != "-" { spent[$1] += $2 + $3; next }
            FILENAME == "-" && spent[$1] < wanted { printf "%d %s\n", spent[$1], $1 }' build-fuzz/spent - | sort -n
}

# Turns of five minutes, two targets at a time, until each has had its CPU time, this time and before together; a
# failure ends it, as its target would only find the same again.
until_spent() { # SECONDS TARGET...
    touch build-fuzz/spent
    while [ -n "$(lacking "$@")" ]; do
        lacking "$@" | head -n 2 | cut -d ' ' -f 2 | xargs -P 2 -I '{}' nice -n 19 bash -c "measured '{}' 300" || return 1
    done
}

case $1 in all | until) ;; *) run "$1" "$2" ;; esac
mkdir -p build-fuzz/log build-fuzz/found
touch build-fuzz/campaign
printf '%-12s %10s %12s %8s %8s %6s %9s\n' target 'cpu s' executions edges crashes leaks timeouts
export -f run found measured
mapfile -t targets < <(for target in tests/fuzz/seeds/*/; do basename "$target"; done)
if [ "$1" = until ]; then
    [ $# -eq 2 ] || targets=("${@:3}")
    until_spent "$2" "${targets[@]}"
    exit
fi
# Two at a time, below everything else that runs; xargs fails if any target did.
printf '%s\n' "${targets[@]}" |
    xargs -P 2 -I '{}' nice -n 19 bash -c "measured '{}' '$2'" || exit 1
