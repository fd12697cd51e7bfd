#!/bin/sh
# Installs libclang where it is missing: the binding of Qhull that tests and benches check against is
# generated with it. Debian or Ubuntu, as root.
set -eu
if ls /usr/lib/llvm-*/lib/libclang*.so* /usr/lib/*/libclang*.so* /usr/lib64/libclang*.so* >/dev/null 2>&1 \
    || [ -n "${LIBCLANG_PATH:-}" ]; then
    exit 0
fi
command -v apt-get >/dev/null || {
    echo "libclang is missing; install it, or set LIBCLANG_PATH, to compare with Qhull" >&2
    exit 1
}
apt-get update
apt-get install --yes --no-install-recommends gcc libc6-dev libclang-dev
