#!/bin/sh
# Runs the sweeps of examples/sweeps over the example meshes: the one with Ray on a real Ray cluster of two nodes on
# this machine, the tasks of Slurm and Kubernetes with the environment that those set.
set -eu
cd "$(dirname "$0")/.."
command -v python3 >/dev/null || { apt-get update && apt-get install --yes python3; }
python=$PWD/target/sweeps/bin/python
if ! cmp -s tests/sweeps.txt target/sweeps/installed; then
    python3 -m venv target/sweeps ||
        { apt-get update && apt-get install --yes python3-venv && python3 -m venv target/sweeps; }
    $python -m pip install --quiet --disable-pip-version-check --retries 10 --requirement tests/sweeps.txt
    cp tests/sweeps.txt target/sweeps/installed
fi
cargo build --locked --bin graspd
exec "$python" tests/sweeps.py "$PWD/target/debug/graspd"
