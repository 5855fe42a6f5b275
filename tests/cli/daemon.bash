# SPDX-License-Identifier: Apache-2.0
# ttfboxd by its file ttfboxd.yaml, for a script that has sourced cli.bash: what it says is in `log`, its process in `daemon`.

# begin_daemon [ENVIRONMENT...]: in the background; its log goes on where it was.
# shellcheck disable=SC2120 # the arguments may be none
begin_daemon() {
    env "$@" "$DAEMON" --config ttfboxd.yaml >>log 2>&1 &
    daemon=$!
}

# heard WORDS [FILE [TIMES [SECONDS]]]: its log, or another file, has these words, within 30 s on a busy machine.
heard() {
    local file=${2:-log} got
    for _ in $(seq $((${4:-30} * 20))); do
        got=$(grep -cF -- "$1" "$file" 2>/dev/null)
        [ "${got:-0}" -ge "${3:-1}" ] && return 0
        sleep 0.05
    done
    fail "$file does not say '$1': $(cat "$file")"
}

# daemon_url: where its interface is, by TCP, once it listens; URL.
daemon_url() {
    heard 'listening at="127'
    URL=http://$(sed -n 's/.*listening at="\(127[^"]*\)".*/\1/p' log | tail -n 1)/api/v1
}

# end_daemon [SIGNAL]: as a person ends it, with 0; by a signal, however it ends.
end_daemon() {
    local got
    kill "-${1:-TERM}" "$daemon"
    { wait "$daemon"; } 2>/dev/null
    got=$?
    [ -n "${1:-}" ] || [ $got = 0 ] || fail "it ended with $got: $(cat log)"
}

# state WORD: within 30 s its status has it; how it is asked is `ask_status` of whoever calls.
state() {
    for _ in $(seq 600); do
        ask_status
        [ "$(json state)" = "$1" ] && return 0
        sleep 0.05
    done
    fail "it is $(json state), not $1: $(cat log)"
}
