#!/bin/sh
# Starts a server, plans a grasp on the duck over HTTP, and shows it. On a terminal the server then
# stays up until Ctrl-C; anywhere else it is stopped again.
set -eu
log=$(mktemp)
target/release/graspd serve --listen 127.0.0.1:0 --log-level warn >"$log" &
server=$!
trap 'kill $server 2>/dev/null || true; wait $server 2>/dev/null || true; rm -f "$log"' EXIT
trap 'exit 130' INT TERM

url=
while [ -z "$url" ]; do
    kill -0 $server 2>/dev/null || { echo "the server did not start" >&2; exit 1; }
    sleep 0.1
    url=$(sed -n 's/^graspd listening on //p' "$log")
done
echo "server    $url"
if command -v curl >/dev/null; then
    set -- sh examples/plan.sh
else
    set -- python3 examples/client.py
fi
"$@" "$url" examples/meshes/duck.obj contacts=4 friction=0.5 generations=300 seed=1

cat <<END

Where to look next, while the server runs:
  curl -F mesh=@examples/meshes/knight.stl -F contacts=5 $url/jobs
      plan another; put your own mesh file in its place
  $url/docs
      every route, to read and to try out
  target/release/graspd plan examples/meshes/rabbit.ply
      the same without a server
END
if [ -t 0 ] && [ -t 1 ]; then
    echo "The server stays up at $url; press Ctrl-C to stop it."
    wait $server
fi
