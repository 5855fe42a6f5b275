# SPDX-License-Identifier: Apache-2.0
# Sourced first by a test that needs a network of its own: it is begun anew in one, with lo and nothing else, or skipped.
if [ -z "${IN_NETWORK:-}" ]; then
    if ! unshare -rn ip link add net0 type veth peer name pc0 2>/dev/null; then
        echo "no network of its own can be made here (unshare -rn, ip, veth)"
        exit 77
    fi
    IN_NETWORK=1 exec unshare -rn bash "$0"
fi
ip link set lo up
