#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Datasets by HTTP, as curl and a browser's programs read them.
. "$(dirname "$0")/cli.bash"
. "$(dirname "$0")/server.bash"

plan p.yaml 'interval: 1h' 'count: 6' 'lamps: {mode: continuous}' 'shots:' \
    '  - {stream: main, channel: white, lamps: {left: 100%, right: 100%}, exposure: 20ms}' 'keep: both' 'mains: 50Hz'
mkdir data
expect 0 "$TTFBOX" capture p.yaml "${TINY[@]}" -o data/grass
echo private >secret
ln -s ../../secret data/grass/frames/main/link.tif

serve data
get "$URL/health" 200
is ok true

# --- what there is, and what it holds
get "$URL/datasets" 200
is datasets.0.name grass
is datasets.0.results.captured 6
is datasets.0.sealed true
[ "$(json datasets.0.digest)" = "$(sha256sum data/grass/SHA256SUMS | cut -c1-64)" ] || fail "the digest is another"
get "$URL/datasets/grass" 200
is slots 6

# --- the records' own bytes, from a cursor on
curl -sS "$URL/datasets/grass/records" | cmp - data/grass/records.jsonl || fail "records differ"
size=$(stat -c %s data/grass/records.jsonl)
curl -sS -r 500- "$URL/datasets/grass/records" | cmp - <(tail -c +501 data/grass/records.jsonl) || fail "a part differs"
get "$URL/datasets/grass/records" 416 -r "$size-"
grep -qi "^Content-Range: bytes \*/$size" headers || fail "it does not say where the end is"

# --- a file, its tag and its digest
f=frames/main/000003.tif
sha=$(sha256sum data/grass/$f | cut -c1-64)
get "$URL/datasets/grass/files/$f" 200
cmp -s out data/grass/$f || fail "the file differs"
grep -qi "^ETag: \"$sha\"" headers || fail "the tag is not the file's SHA-256"
grep -qiF "Repr-Digest: sha-256=:$(xxd -r -p <<<"$sha" | base64):" headers || fail "the digest is not the file's"
get "$URL/datasets/grass/files/$f" 304 -H "If-None-Match: \"$sha\""
get "$URL/datasets/grass/files/$f" 206 -r 10-19 -H "If-Range: \"$sha\""
[ "$(stat -c %s out)" = 10 ] || fail "a part of 10 bytes has another length"
get "$URL/datasets/grass/files/$f" 200 -r 10-19 -H 'If-Range: "another"'

# --- all of it as an archive, whole and from the middle on
rm data/grass/frames/main/link.tif
get "$URL/datasets/grass/tar" 200
cp out whole.tar
mkdir unpacked
tar -C unpacked -xf whole.tar || fail "tar does not read it"
diff -r data/grass unpacked/grass || fail "the archive holds another dataset"
get "$URL/datasets/grass/tar" 206 -r 7000-
cmp -s out <(tail -c +7001 whole.tar) || fail "the second part of the archive differs"
expect 0 "$TTFBOX" verify unpacked/grass
ln -s ../../../../secret data/grass/frames/main/link.tif

# --- what is not there, and what may not be
get "$URL/datasets/nobody" 404
get "$URL/datasets/nobody/records" 404
get "$URL/datasets/grass/files/frames/main/999999.tif" 404
get "$URL/datasets/grass/files/frames/main/link.tif" 404
for path in ../../secret %2e%2e/%2e%2e/secret ..%2f..%2fsecret /etc/passwd %2fetc%2fpasswd frames/../../../secret \
    'frames\..\..\secret' .%00./secret; do
    get "$URL/datasets/grass/files/$path" 404 --path-as-is
    grep -q private out && fail "$path leads out of the folder"
done
get "$URL/datasets" 421 -H 'Host: made-to-point-here.example'
get "$URL/datasets" 405 -X POST
grep -qi '^Allow: GET' headers || fail "it does not say what may be done"
get "$URL/datasets" 413 -X GET -d 'a=b'
get "$URL/datasets" 405 -d 'a=b'
get "$URL/datasets/grass" 405 -X DELETE
[ -e data/grass/dataset.json ] || fail "it is gone"
grep -qi "^Access-Control" headers && fail "pages from elsewhere may read"
get "$URL/datasets" 200
for header in "X-Content-Type-Options: nosniff" "Content-Security-Policy: default-src 'none'" \
    "Cross-Origin-Resource-Policy: same-origin"; do
    grep -qi "^$header" headers || fail "without $header"
done

# --- the page's own files may use this server, and nothing inline or of others
get "${URL%/api/v1}/" 200
policy=$(sed -n 's/^Content-Security-Policy: *//Ip' headers | tr -d '\r')
for part in "default-src 'none'" "script-src 'self'" "style-src 'self'" "connect-src 'self'" "base-uri 'none'" "form-action 'none'" "frame-ancestors 'none'"; do
    case "; $policy;" in *"; $part;"*) ;; *) fail "without $part: $policy" ;; esac
done
case $policy in *unsafe* | *'*'* | *http* | *//* | *nonce* | *sha256*) fail "it lets more in: $policy" ;; esac

# --- notes and events: nothing where nobody said anything, else the file's own bytes
rm -f data/grass/notes.jsonl
get "$URL/datasets/grass/notes" 200
[ -s out ] && fail "notes that nobody made"
expect 0 "$TTFBOX" note data/grass "watered" --slots 2-3
get "$URL/datasets/grass/notes" 200
cmp -s out data/grass/notes.jsonl || fail "the notes differ"
get "$URL/datasets/grass/events" 200
get "$URL/datasets/nobody/notes" 404

# --- a damaged dataset does not hide the others
mkdir data/broken
echo '{"format":' >data/broken/dataset.json
get "$URL/datasets" 200
is datasets.0.name broken
json datasets.0.error | grep -q . || fail "it does not say what is wrong with it"
is datasets.1.name grass

# --- while it is captured: what stands is served, half a line is not
cp -r data/grass data/growing
rm data/growing/SHA256SUMS
head -n 4 data/grass/records.jsonl >data/growing/records.jsonl
size=$(stat -c %s data/growing/records.jsonl)
get "$URL/datasets/growing" 200
before=$(json slots)
printf '{"type":"slot","se' >>data/growing/records.jsonl
get "$URL/datasets/growing/records" 416 -r "$size-"
head -n 5 data/grass/records.jsonl >data/growing/records.jsonl
get "$URL/datasets/growing/records" 206 -r "$size-"
cmp -s out <(tail -n +5 data/grass/records.jsonl | head -n 1) || fail "the new line differs"
get "$URL/datasets/growing" 200
is slots $((before + 1))

# --- somebody who means harm
"$PYTHON" "$HERE/hostile.py" "${URL#http://}" || fail "a hostile client had its way"
# It does not ask for more and more memory: 100 bytes lost of each connection are 1,300 KiB for three rounds, a request's own memory lost of
# each request 600 KiB. Threads that for once want memory all at the same time may cost as much, for once; what is lost is lost each time.
hostile() {
    for _ in $(seq "$1"); do
        "$PYTHON" "$HERE/hostile.py" "${URL#http://}" 40 || fail "a hostile client had its way"
    done
}
levels_off() {
    local before
    for _ in 1 2 3; do
        before=$(asked_for "$SERVER")
        hostile 3
        [ $(($(asked_for "$SERVER") - before)) -gt 256 ] || return 0
    done
    return 1
}
hostile 1
before=$(asked_for "$SERVER")
if sanitized "$TTFBOX"; then
    hostile 3
else
    levels_off || fail "it grew on and on from $before KiB to $(asked_for "$SERVER") KiB"
fi
# Half requests are given up after 30 s of silence.
for _ in $(seq 45); do
    descriptors=$(find "/proc/$SERVER/fd" -type l | wc -l)
    [ "$descriptors" -gt 12 ] || break
    sleep 1
done
[ "$descriptors" -le 12 ] || fail "$descriptors descriptors are still open"
get "$URL/health" 200
unserve

# --- others need the token; it is not in the list of processes
serve data --listen 127.0.0.1:0 --token-file token
unserve
[ "$(stat -c %a token)" = 600 ] || fail "others can read the token"
serve data --listen 0.0.0.0:0 --token-file token
get "$URL/health" 200
get "$URL/datasets" 401
get "$URL/datasets" 401 -H 'Authorization: Bearer 0123456789abcdef'
get "$URL/datasets" 200 -H "Authorization: Bearer $(cat token)"
unserve

# --- an interface by its name: the address that it has
serve data --listen lo:0
[[ $URL == http://127.0.0.1:* ]] || fail "lo is at $URL"
get "$URL/health" 200
unserve
expect 1 "$TTFBOX" serve data --listen nowhere0:8417
said err 'there is no network interface of this name'

# --- a socket of the file system, and what cannot be listened on
serve data --listen unix:box
curl -sS --unix-socket box http://localhost/api/v1/datasets >out || fail "nobody answers on the socket"
is datasets.1.name grass
expect 1 "$TTFBOX" serve data --listen unix:box
said err 'another program listens there'
unserve
mkdir 'a "quoted" folder'
serve data --listen 'unix:a "quoted" folder/box'
"$PYTHON" -c 'import json, sys; assert json.load(open("listening"))["listening"] == sys.argv[1]' 'unix:a "quoted" folder/box' ||
    fail "where it listens is no JSON"
unserve
expect 2 "$TTFBOX" serve data --listen here
said err 'ADDRESS:PORT'
expect 2 "$TTFBOX" serve nowhere
said err 'nowhere'

# --- what it says to a person is what a browser takes
expect 124 timeout -k 5 1 "$TTFBOX" serve data --listen 127.0.0.1:0
grep -Eq '^serving data at http://127\.0\.0\.1:[0-9]+$' out || fail "no address that a browser takes: $(cat out)"
expect 124 timeout -k 5 1 "$TTFBOX" serve data --listen "unix:$WORK/said"
said out "serving data at unix:$WORK/said"
