#!/bin/sh
# Asks a server of its own everything that its description says may be asked, and much that it says may not,
# and holds each answer against the description. GRASPD_EXAMPLES is how many cases are made up per operation,
# GRASPD_PHASES which kinds; the default takes less than a minute, `make conformance` has more than 2,000 cases.
set -eu
cd "$(dirname "$0")/.."
sh tests/install.sh curl venv
. tests/binary.sh
. tests/server.sh
start_server 127.0.0.1:0 --max-job-seconds 1

# A mesh, a job and a batch that are here.
member() { python3 -c "import json, sys; print(json.load(sys.stdin)['$1'])"; }
job=$(curl -sS --fail-with-body -F mesh=@examples/meshes/box.stl -F seed=1 -F generations=2 "$url/jobs")
GRASPD_JOB=$(printf %s "$job" | member id)
GRASPD_MESH=$(printf %s "$job" | member mesh_id)
GRASPD_BATCH=$(curl -sS --fail-with-body --json "{\"meshes\": [\"$GRASPD_MESH\"], \"request\": {\"generations\": 2}}" \
    "$url/batches" | member id)
export GRASPD_JOB GRASPD_MESH GRASPD_BATCH
while curl -sS "$url/jobs/$GRASPD_JOB" | grep -qE '"state":"(queued|running)"'; do sleep 0.2; done

# It keeps what it has found where it is run, and tries that first the next time.
config=$PWD/tests/conformance.toml
python=$PWD/target/python/bin
cd "$data"
$python/schemathesis --config-file "$config" run "$url/openapi.json" --checks all \
    --phases "${GRASPD_PHASES:-fuzzing,stateful}" --max-examples "${GRASPD_EXAMPLES:-20}" --seed 1 \
    --workers 2 --continue-on-failure --request-timeout 40 --no-color
kill -0 $server || { echo "the server did not survive" >&2; exit 1; }
