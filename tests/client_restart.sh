#!/bin/sh
# The Python client against a server that is killed while it plans, and away for a while: it ends as if
# nothing had been.
set -eu
cd "$(dirname "$0")/.."
data=$(mktemp -d)
server=
stop() { [ -z "$server" ] || { kill -9 "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; }; }
trap 'stop; rm -rf "$data"' EXIT

start() {
    : >"$data/log"
    target/debug/graspd serve --listen "$1" --data-dir "$data/server" >"$data/log" 2>"$data/errors" &
    server=$!
    url=
    while [ -z "$url" ]; do
        kill -0 $server || { cat "$data/errors" >&2; exit 1; }
        sleep 0.1
        url=$(sed -n 's/^graspd listening on //p' "$data/log")
    done
}

start 127.0.0.1:0
address=${url#http://}
stop
# It is sent before there is a server.
GRASPD_DEADLINE=60 python3 examples/client.py "http://$address" examples/meshes/duck.obj contacts=4 seed=1 \
    generations=100 >"$data/output" 2>&1 &
client=$!
sleep 1
start "$address"
while ! grep -q '^job' "$data/output"; do
    kill -0 $client || { cat "$data/output" >&2; exit 1; }
    sleep 0.1
done
sleep 0.5
stop
sleep 1
start "$address"
wait $client || { cat "$data/output" >&2; exit 1; }
grep -q '^quality' "$data/output" || { cat "$data/output" >&2; exit 1; }
jobs=$(curl -sS "$url/jobs" | grep -o '"attempt"' | wc -l)
[ "$jobs" = 1 ] || { echo "$jobs jobs instead of one" >&2; exit 1; }
stop
# With nobody there it gives up in time, and says why.
if GRASPD_DEADLINE=2 timeout 20 python3 examples/client.py "http://$address" examples/meshes/duck.obj 2>"$data/output"; then
    echo "the client does not notice that nobody is there" >&2
    exit 1
fi
grep -q '^no answer from the server' "$data/output" || { cat "$data/output" >&2; exit 1; }
echo "client: a server that is killed and comes back does not disturb it"
