#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ttfbox starts without the libraries that few commands need, and hands those commands over to ttfbox-full.
. "$(dirname "$0")/cli.bash"

FULL=$(dirname "$TTFBOX")/../lib/ttfbox/ttfbox-full
needs() { readelf -d "$1" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p'; }
needs "$FULL" >full.needs
ldd "$TTFBOX" | tr -d '\t' >own.needs # those behind the first ones, too
for library in libcurl libmicrohttpd libusb; do
    grep -q "^$library" full.needs || fail "ttfbox-full does not need $library: what does it do?"
    grep "^$library" own.needs && fail "ttfbox loads $library at each start"
done
grep '^libarchive' own.needs && fail "ttfbox loads libarchive at each start"

# A command that is handed over is the same as if it were not: its words, what it says, how it ends.
expect 0 "$TTFBOX" usb list --json
json boxes >/dev/null
expect 2 "$TTFBOX" serve "no such folder"
said err "ttfbox serve: no such folder: "
expect 2 "$TTFBOX" serve "no such folder" --js --listen=127.0.0.1:0
is exit 2
expect 2 "$TTFBOX" serve --json -- "no such folder"
is exit 2
is where "no such folder"
expect 2 "$TTFBOX" pull --no-such-option
said err "no-such-option"
expect 1 "$TTFBOX" pull here --box http://127.0.0.1:1
said err "ttfbox pull: http://127.0.0.1:1: "
[ -e here ] && fail "something was made of a box that is not there"

# A copy of ttfbox alone: all but those commands, and of them what is missing.
mkdir alone prefix prefix/bin prefix/lib prefix/lib/ttfbox
cp "$TTFBOX" alone
expect 0 alone/ttfbox board show --board sim-small
expect 0 alone/ttfbox pull --help
expect 1 alone/ttfbox usb list --json
said err "ttfbox usb list: ttfbox-full: "
said err "copy it along"
is where ttfbox-full
expect 1 alone/ttfbox board probe --board sim-small --bundle report.tar.gz
said err "ttfbox-full"
[ -e report.tar.gz ] && fail "a report of nothing"
# A file of that name that may not be run is told from none.
touch alone/ttfbox-full
expect 1 alone/ttfbox usb list
said err "ttfbox-full: this program does the command, and may not be run"
# Beside it, and as it is installed.
rm alone/ttfbox-full
cp "$FULL" alone
expect 0 alone/ttfbox usb list
cp "$TTFBOX" prefix/bin
cp "$FULL" prefix/lib/ttfbox
expect 0 prefix/bin/ttfbox usb list
ln -s "$WORK/prefix/bin/ttfbox" linked
expect 0 ./linked usb list
if grep -q '^libarchive' full.needs; then
    expect 0 prefix/bin/ttfbox board probe --board sim-small --bundle report.tar.gz
    tar tzf report.tar.gz >members
    grep -q BUNDLE.txt members || fail "the report has no words"
fi
# One that is no program of this machine is said so.
printf 'nonsense' >alone/ttfbox-full
expect 1 alone/ttfbox usb list
said err "cannot be run"
echo "hand_over: what few commands need costs the others nothing"
