# Starts and stops the servers of the load and soak scripts, each on a new folder; to be sourced at the top of
# the repository. What the environment says of GRASPD_ settings holds for them too.
data=$(mktemp -d)
server=
stop_server() {
    [ -n "$server" ] || return 0
    kill "$server" 2>/dev/null || true
    wait "$server" 2>/dev/null || true
    server=
    rm -rf "$data/server"
}
trap 'stop_server; rm -rf "$data"' EXIT
trap 'exit 130' INT TERM

# start_server FLAG...: sets $server and $url.
start_server() {
    : >"$data/log"
    target/release/graspd serve --listen 127.0.0.1:0 --data-dir "$data/server" --log-level error \
        --queue-capacity 1000000 "$@" >"$data/log" 2>"$data/errors" &
    server=$!
    url=
    while [ -z "$url" ]; do
        kill -0 $server 2>/dev/null || { cat "$data/errors" >&2; exit 1; }
        sleep 0.1
        url=$(sed -n 's/^graspd listening on //p' "$data/log")
    done
}
