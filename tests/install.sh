#!/bin/sh
# Installs what tests and benchmarks need beside Rust and Node, where it is missing: Debian or Ubuntu, as root.
#     sh tests/install.sh [python3|libclang|curl|venv|postgresql|faketime|deploy|chromium|wrk|valgrind]...
# Without arguments all that the tests need. `venv` is the Python environment of the tests, in target/python.
set -eu
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || set -- python3 libclang curl venv postgresql faketime deploy chromium

# Several tests may find the same thing missing at the same time.
exec 9>>"${TMPDIR:-/tmp}/graspd-install.lock"
flock 9

packages=
# need PACKAGE... -- COMMAND...: the packages are needed unless the command succeeds.
need() {
    wanted=
    while [ "$1" != -- ]; do
        wanted="$wanted $1"
        shift
    done
    shift
    "$@" >/dev/null 2>&1 || packages="$packages$wanted"
}
has_libclang() {
    [ -n "${LIBCLANG_PATH:-}" ] || ls /usr/lib/llvm-*/lib/libclang.so* /usr/lib/llvm-*/lib/libclang-*.so* \
        /usr/lib/*/libclang.so* /usr/lib/*/libclang-[0-9]*.so* /usr/lib64/libclang*.so* 2>/dev/null | grep -q .
}
for thing; do
    case $thing in
    python3) need python3 -- command -v python3 ;;
    # The binding of Qhull is generated with it.
    libclang) need gcc libc6-dev libclang-dev -- has_libclang ;;
    curl) need curl -- command -v curl ;;
    venv) need python3 python3-venv -- python3 -c 'import ensurepip' ;;
    postgresql) [ -n "${GRASPD_POSTGRES_BIN:-}" ] || need postgresql -- ls /usr/lib/postgresql/*/bin/postgres ;;
    # Moves the clock of a process.
    faketime) need libfaketime -- ls /usr/lib/*/faketime/libfaketime.so.1 ;;
    deploy)
        need haproxy -- command -v haproxy
        need prometheus -- command -v promtool
        need dnsmasq-base -- command -v dnsmasq
        need iproute2 -- command -v ip
        ;;
    chromium) need chromium -- command -v chromium ;;
    # Benchmarks alone need these.
    wrk) need wrk -- command -v wrk ;;
    valgrind) need valgrind -- command -v valgrind ;;
    *)
        echo "$thing: nothing that this script installs" >&2
        exit 2
        ;;
    esac
done
if [ -n "$packages" ]; then
    command -v apt-get >/dev/null || { echo "missing, and there is no apt-get to install it:$packages" >&2; exit 1; }
    # shellcheck disable=SC2086 # words
    install() { DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends $packages; }
    # The lists of a new machine are empty or old, and a mirror may fail for a moment.
    install || { apt-get update && install; } || { sleep 5 && apt-get update && install; }
fi

for thing; do
    if [ "$thing" = venv ] && ! cmp -s tests/requirements.txt target/python/installed; then
        [ -x target/python/bin/pip ] || python3 -m venv target/python
        target/python/bin/pip install --quiet --disable-pip-version-check --retries 10 --requirement tests/requirements.txt
        cp tests/requirements.txt target/python/installed
    fi
done
