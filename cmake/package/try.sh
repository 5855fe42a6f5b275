#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# try.sh: the packages of this machine's processor in a fresh Debian: installed, used, removed, purged. README.md.
set -euo pipefail
here=$(cd "$(dirname "$(readlink -f "$0")")" && pwd)
arch=$(dpkg --print-architecture)
debs=$here/../../build-package/$arch
# shellcheck disable=SC2016 # apt's own placeholders
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep -v security | head -n 1)
log=$(mktemp)
trap 'rm -f "$log"' EXIT

lintian --fail-on error,warning "$debs"/*.deb 2>"$log" || { cat "$log" >&2; exit 1; }
echo "lintian has nothing to say"
# All in the hooks: so it needs neither root nor a folder that has to be cleared away.
# shellcheck disable=SC2016 # the hook's own $1
if ! mmdebstrap --quiet --variant=minbase --format=null --include=systemd,man-db \
    --customize-hook="mkdir \"\$1/debs\" && cp \"$debs\"/*.deb \"$here/try-inside.sh\" \"\$1/debs/\"" \
    --customize-hook='chroot "$1" sh /debs/try-inside.sh' \
    bookworm - "deb $mirror bookworm main" >"$log" 2>&1; then
    tail -n 30 "$log" >&2
    exit 1
fi
grep '^try: ' "$log" | sed 's/^try: //'
