#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# newer.sh FOLDER SUITE: FOLDER/tree, the arm64 libraries of a newer suite to compile against, and to run what was
# compiled. No kernel: the machine has its own (tree.sh). Made anew only when the list of packages changes.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=$1 suite=$2
. "$here/../../cmake/dev/install.sh"

# base-files has the links that programs find their loader by; the compiler is this machine's, so its own libraries are of its version.
wanted="base-files libgcc-12-dev libstdc++-12-dev $(tr -s ' \n' '\n' <<<"$ttf_build_packages" | grep -- '-dev$')"
# shellcheck disable=SC2016 # apt's own placeholders
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep -v security | sed -n 1p)
stamp=$(cat "$0" - <<<"$suite $wanted" | sha256sum | cut -c1-64)
[ "$(cat "$out/stamp" 2>/dev/null || true)" != "$stamp" ] || exit 0
rm -rf "$out"
mkdir -p "$out"
echo "rig: making an arm64 tree of $suite (half a minute, 230 MB)" >&2
mmdebstrap --quiet --variant=extract --architectures=arm64 --include="$(echo "$wanted" | tr -s ' \n' ',')" \
    "$suite" "$out/tree" "deb $mirror $suite main" >"$out/mmdebstrap.log" 2>&1 ||
    { tail -n 20 "$out/mmdebstrap.log" >&2; exit 75; }
chmod 755 "$out/tree"
echo "$stamp" >"$out/stamp"
