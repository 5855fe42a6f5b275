# SPDX-License-Identifier: Apache-2.0
# `ttfbox serve` for a script that has sourced cli.bash.

# serve FOLDER [OPTIONS]: starts it; URL is where its interface is, SERVER its process.
serve() {
    local folder=$1 tries
    shift
    case "$*" in *--listen*) ;; *) set -- --listen 127.0.0.1:0 "$@" ;; esac
    : >listening
    "$TTFBOX" serve "$folder" --json "$@" >listening 2>serving &
    SERVER=$!
    for tries in $(seq 200); do
        [ -s listening ] && break
        kill -0 "$SERVER" 2>/dev/null || fail "it does not serve: $(cat serving)"
        sleep 0.05
    done
    [ -s listening ] || fail "it does not say where it listens ($tries looks)"
    URL=http://$(sed 's/.*"listening":"\([^"]*\)".*/\1/; s/0\.0\.0\.0/127.0.0.1/' listening)/api/v1
}

# unserve: ends it as Ctrl-C does.
unserve() {
    kill -TERM "$SERVER"
    wait "$SERVER" || fail "it ended with $?: $(cat serving)"
}

# get URL STATUS [curl's options]: the body is in $WORK/out, the headers in $WORK/headers.
get() {
    local url=$1 status=$2 got
    shift 2
    rm -f out
    got=$(curl -sS -D headers -o out -w '%{http_code}' "$@" "$url") || fail "curl $* $url: $?"
    [ -e out ] || : >out
    [ "$got" = "$status" ] || fail "$url: $got instead of $status"
}

# asked_for PID: how much memory of its own it has asked the kernel for, in KiB. What it holds of that (VmRSS) grows for some 20 hostile rounds,
# by a third, while its heap's free places are written to one after the other; this does not.
asked_for() {
    sed -n 's/^VmData:[^0-9]*\([0-9]*\) kB/\1/p' "/proc/$1/status"
}
