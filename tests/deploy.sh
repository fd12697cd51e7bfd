#!/bin/sh
# Holds deploy/ against what can be had without a container engine: the schemas of Compose and of Kubernetes, what
# the files say of one another, the flags of the program; then runs the fleet of deploy/compose.yaml on real programs
# with the files as they are, in a network of its own, which takes root. GRASPD_ALLOW_SKIP=1 lets that be skipped.
set -eu
cd "$(dirname "$0")/.."
sh tests/install.sh venv postgresql deploy
. tests/binary.sh
python=$PWD/target/python/bin

$python/yamllint --strict --config-file tests/deploy/yamllint.yaml deploy examples/sweeps
$python/check-jsonschema --builtin-schema vendor.compose-spec deploy/compose.yaml
"$python/python" tests/deploy/files.py "$binary"
haproxy -c -q -f deploy/haproxy.cfg
promtool check rules deploy/alerts.yml
promtool test rules tests/deploy/alerts_test.yml

if [ "$(id -u)" != 0 ] && [ "${GRASPD_ALLOW_SKIP:-}" = 1 ]; then
    echo "deploy: the fleet is not run, which takes root"
    exit 0
fi
exec unshare --net --mount --pid --fork --kill-child --mount-proc -- \
    sh -eu -c 'ip link set lo up; exec "$@"' sh "$python/python" tests/deploy/stack.py "$binary"
