#!/bin/sh
# Runs the sweeps of examples/sweeps over the example meshes: the one with Ray on a real Ray cluster of two nodes on
# this machine, the tasks of Slurm and Kubernetes with the environment that those set.
set -eu
cd "$(dirname "$0")/.."
sh tests/install.sh venv
. tests/binary.sh
exec "$PWD/target/python/bin/python" tests/sweeps.py "$binary"
