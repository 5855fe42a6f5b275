#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# `ttfbox serve` listens at a network interface that gets another address, goes, and comes again: in a network of its own.
. "$(dirname "$0")/network.bash"
. "$(dirname "$0")/cli.bash"
. "$(dirname "$0")/server.bash"

plug() { # ADDRESS
    ip link add net0 type veth peer name pc0
    ip link set net0 up
    ip addr add "$1/24" dev net0
}
said() { # WORDS FILE
    local tries
    for tries in $(seq 600); do
        grep -qF -- "$1" "$2" && return 0
        sleep 0.05
    done
    fail "after $tries looks $2 does not say '$1': $(cat listening serving)"
}
there() { # ADDRESS
    said "{\"listening\":\"$1:8417\",\"free_to_read\":false}" listening
    get "http://$1:8417/api/v1/datasets" 200 -H "Authorization: Bearer $(cat token)"
    get "http://$1:8417/api/v1/datasets" 401
}
gone() { # ADDRESS
    said "$1:8417 is the address of net0:8417 no more" serving
    curl -sS -m 5 -o out "http://$1:8417/api/v1/health" 2>err && fail "$1 still answers"
}

mkdir data
umask 077
head -c 24 /dev/urandom | xxd -p >token

# --- at its start it must be there, and have an address: a word mistyped is not waited for
expect 1 "$TTFBOX" serve data --listen net0:8417 --token-file token
grep -q 'no network interface of this name' err || fail "it does not say that there is no such interface: $(cat err)"
ip link add net0 type veth peer name pc0
expect 1 "$TTFBOX" serve data --listen net0:8417 --token-file token
ip link del net0

# --- from then on it is followed
plug 10.9.0.1
serve data --listen net0:8417 --token-file token
there 10.9.0.1
ip addr del 10.9.0.1/24 dev net0
gone 10.9.0.1
said 'waiting: net0:8417' serving
ip addr add 10.9.0.2/24 dev net0
there 10.9.0.2
ip link del net0
gone 10.9.0.2
plug 10.9.0.3
there 10.9.0.3
[ "$(grep -c waiting serving)" = 2 ] || fail "that it waits is not told once each time: $(cat serving)"
unserve
