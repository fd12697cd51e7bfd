#!/bin/sh
# Holds deploy/ against what can be had without a container engine: the schemas of Compose and of Kubernetes, what
# the files say of one another, the flags of the program; then runs the fleet of deploy/compose.yaml on real programs
# with the files as they are, in a network of its own, which takes root. GRASPD_ALLOW_SKIP=1 lets that be skipped.
set -eu
cd "$(dirname "$0")/.."
install() {
    for _ in 1 2 3; do
        apt-get update && apt-get install --yes --no-install-recommends "$@" && return
        sleep 5
    done
    return 1
}
for program in haproxy prometheus dnsmasq ip python3 /usr/lib/postgresql/*/bin/initdb; do
    command -v "$program" >/dev/null || {
        install haproxy prometheus dnsmasq-base iproute2 python3 python3-venv postgresql
        break
    }
done
python=$PWD/target/deploy/bin/python
if ! cmp -s tests/deploy.txt target/deploy/installed; then
    python3 -m venv target/deploy || { install python3-venv && python3 -m venv target/deploy; }
    $python -m pip install --quiet --disable-pip-version-check --retries 10 --requirement tests/deploy.txt
    cp tests/deploy.txt target/deploy/installed
fi
cargo build --locked --bin graspd
binary=$PWD/target/debug/graspd

target/deploy/bin/yamllint --strict --config-file tests/deploy/yamllint.yaml deploy examples/sweeps
target/deploy/bin/check-jsonschema --builtin-schema vendor.compose-spec deploy/compose.yaml
"$python" tests/deploy/files.py "$binary"
haproxy -c -q -f deploy/haproxy.cfg
promtool check rules deploy/alerts.yml
promtool test rules tests/deploy/alerts_test.yml

if [ "$(id -u)" != 0 ] && [ "${GRASPD_ALLOW_SKIP:-}" = 1 ]; then
    echo "deploy: the fleet is not run, which takes root"
    exit 0
fi
exec unshare --net --mount --pid --fork --kill-child --mount-proc -- \
    sh -eu -c 'ip link set lo up; exec "$@"' sh "$python" tests/deploy/stack.py "$binary"
