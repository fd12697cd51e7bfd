#!/bin/sh
# How the service takes load: a Markdown table on standard output, for docs/load.md. A quarter of an hour;
# wants an idle machine.
set -eu
cd "$(dirname "$0")/.."
sh tests/install.sh wrk curl
cargo build --quiet --release --locked --bin graspd
cargo bench --quiet --locked --bench load --no-run
binary=$PWD/target/release/graspd
. tests/server.sh
# On a folder of its own, with nothing in it.
new_server() {
    rm -rf "$data/server"
    start_server 127.0.0.1:0 --log-level error --queue-capacity 1000000 "$@"
}
driver() { timeout 900 cargo bench --quiet --locked --bench load -- "$url" "$@"; }

echo "| what | count | p50 ms | p99 ms | max ms | |"
echo "|---|---|---|---|---|---|"

new_server
mesh=$(curl -sS --fail-with-body -F mesh=@examples/meshes/box.stl "$url/meshes" | sed 's/^{"id":"\([^"]*\)".*/\1/')
export GRASPD_BODY="{\"mesh_id\":\"$mesh\",\"method\":\"random\",\"population\":2,\"generations\":1,\"candidates\":\"triangles\",\"seed\":1}"
timeout 120 wrk --threads 2 --connections 32 --duration 20s --timeout 10s --script benches/load.lua "$url/jobs" \
    2>&1 >"$data/wrk"
stop_server

new_server
driver overhead 1000
stop_server

new_server
driver queue 10000
stop_server

new_server
driver keys 64 10000 100
echo "| jobs kept after that | $(curl -sS "$url/jobs?limit=1000" | grep -o '"attempt"' | wc -l) | | | | of at most 1000 listed |"
stop_server

new_server --workers 2
driver cancels 1000
stop_server

GRASPD_TERMS=100 timeout 900 cargo test --quiet --locked --test chaos orderly -- --nocapture >"$data/ends"
sed -n 's/^\(100 ends\), \(.*\): median \(.*\), longest \(.*\)$/| SIGTERM to exit | \1 | \3 | | \4 | under load; \2 |/p' "$data/ends"
