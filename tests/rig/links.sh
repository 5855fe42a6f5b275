#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# links.sh TREE: libraries whose link for the linker leads to the root of the file system, led to the tree's own: in a tree
# that root is another one, and the linker would take the static library in silence.
set -euo pipefail
find "$1/usr/lib/aarch64-linux-gnu" -maxdepth 1 -name '*.so' -type l -lname '/*' | while read -r link; do
    to=$1$(readlink "$link")
    [ ! -e "$to" ] || ln -sfr "$to" "$link"
done
