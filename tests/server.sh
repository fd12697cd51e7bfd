# Starts and stops the server of a script, on $data/server; to be sourced at the top of the repository. $data is
# a new folder that goes when the script ends. The program is $binary. What the
# environment says of GRASPD_ settings holds for the server too.
data=$(mktemp -d)
server=
trap 'stop_server; rm -rf "$data"' EXIT
trap 'exit 130' INT TERM

# stop_server [SIGNAL]: ends it, if it runs, and waits for its end.
stop_server() {
    [ -n "$server" ] || return 0
    kill -s "${1:-TERM}" "$server" 2>/dev/null || true
    wait "$server" 2>/dev/null || true
    server=
}

# start_server ADDRESS:PORT FLAG...: sets $server, $url and $address; port 0 takes a free one.
start_server() {
    wanted=$1
    shift
    : >"$data/log"
    "$binary" serve --listen "$wanted" --data-dir "$data/server" "$@" \
        >"$data/log" 2>"$data/errors" &
    server=$!
    url=
    while [ -z "$url" ]; do
        kill -0 "$server" 2>/dev/null || { cat "$data/errors" >&2; exit 1; }
        sleep 0.1
        url=$(sed -n 's/^graspd listening on //p' "$data/log")
    done
    address=${url#http://}
}
