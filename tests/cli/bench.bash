# SPDX-License-Identifier: Apache-2.0
# A box of small pictures in real time, for a script that has sourced cli.bash.

# bench_box [LINE...]: its board, box.yaml, with these lines more; what is appended to the file belongs to `sim:`.
# A sample's age must not come from the machine's clock, hence the daylight.
# shellcheck disable=SC2120 # the arguments may be none
bench_box() {
    {
        printf '%s\n' 'board: bench' 'cameras: {main: {backend: sim}}' 'clock: {backend: machine}' 'lock: box.lock' "$@"
        printf '%s\n' 'sim:' '  daylight: 1' '  sensor: {width: 96px, height: 64px}' '  timing: {exposure_max: 100ms}'
    } >box.yaml
}

# data_in_memory: the folder `data` in memory where there is such: a disk that is busy otherwise is not to answer whether a slot was missed.
data_in_memory() {
    [ -w /dev/shm ] || return 0
    MEMORY=$(mktemp -d /dev/shm/ttfbox-cli.XXXXXX) && ln -s "$MEMORY" data
}

# bench_first: of all that the machine has to do, what this script's session does comes first: the box, and those who use it, between whom all stays as it
# was. Whether the one keeps the other from a slot can be judged then, whatever else is going on. Where that is not allowed (it takes root) the
# machine's other work counts, too.
bench_first() {
    chrt -o -p 0 $$ 2>/dev/null
    echo -20 2>/dev/null >/proc/self/autogroup
    return 0
}
