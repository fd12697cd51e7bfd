#!/bin/sh
# The Python client against a server that is killed while it plans, and away for a while: it ends as if
# nothing had been.
set -eu
cd "$(dirname "$0")/.."
. tests/binary.sh
. tests/server.sh

start_server 127.0.0.1:0
stop_server KILL
# It is sent before there is a server.
GRASPD_DEADLINE=60 python3 examples/client.py "http://$address" examples/meshes/duck.obj contacts=4 seed=1 \
    generations=100 >"$data/output" 2>&1 &
client=$!
sleep 1
start_server "$address"
while ! grep -q '^job' "$data/output"; do
    kill -0 $client || { cat "$data/output" >&2; exit 1; }
    sleep 0.1
done
sleep 0.5
stop_server KILL
sleep 1
start_server "$address"
wait $client || { cat "$data/output" >&2; exit 1; }
grep -q '^quality' "$data/output" || { cat "$data/output" >&2; exit 1; }
jobs=$(curl -sS "$url/jobs" | grep -o '"attempt"' | wc -l)
[ "$jobs" = 1 ] || { echo "$jobs jobs instead of one" >&2; exit 1; }
stop_server KILL
# With nobody there it gives up in time, and says why.
if GRASPD_DEADLINE=2 timeout 20 python3 examples/client.py "http://$address" examples/meshes/duck.obj 2>"$data/output"; then
    echo "the client does not notice that nobody is there" >&2
    exit 1
fi
tail -n 1 "$data/output" | grep -q '^no answer from the server: .*refused' || { cat "$data/output" >&2; exit 1; }
grep -q '; again in [0-9.]* s$' "$data/output" || { cat "$data/output" >&2; exit 1; }
# Nor does it try for long what cannot be.
if timeout 20 python3 examples/client.py "$address" examples/meshes/duck.obj 2>"$data/output"; then
    echo "the client takes an address without http://" >&2
    exit 1
fi
grep -q 'http://' "$data/output" || { cat "$data/output" >&2; exit 1; }
echo "client: a server that is killed and comes back does not disturb it"
