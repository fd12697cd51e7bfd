#!/bin/sh
# Runs every command that README.md shows behind a `$`, and the three clients, against a server of
# its own, and its Python on the example of Standard Webhooks: documentation that does not run is wrong.
set -eu
cd "$(dirname "$0")/.."
for tool in curl python3; do
    command -v $tool >/dev/null || { apt-get update && apt-get install --yes $tool; }
done
cargo build --locked --bin graspd --example client

data=$(mktemp -d)
target/debug/graspd serve --listen 127.0.0.1:0 --data-dir "$data/server" >"$data/log" 2>"$data/errors" &
server=$!
trap 'kill $server 2>/dev/null || true; wait $server 2>/dev/null || true; rm -rf "$data"' EXIT
url=
while [ -z "$url" ]; do
    kill -0 $server || { cat "$data/errors" >&2; exit 1; }
    sleep 0.1
    url=$(sed -n 's/^graspd listening on //p' "$data/log")
done
address=${url#http://}

PATH=$PWD/target/debug:$PATH
ID=
sed -n 's/^\$ //p' README.md >"$data/commands"
[ -s "$data/commands" ] || { echo "README.md shows no command" >&2; exit 1; }
while IFS= read -r command; do
    command=$(printf '%s' "$command" | sed "s/localhost:8080/$address/g; s/curl /curl --fail-with-body /")
    echo "\$ $command"
    eval "$command" >"$data/output" </dev/null || { cat "$data/output" >&2; echo "failed: $command" >&2; exit 1; }
    cut -c1-200 "$data/output" | head -n 5
    # The walk-through goes on with the job of its first command.
    [ -n "$ID" ] || ID=$(tr -d '\r' <"$data/output" | sed -n 's|^[Ll]ocation: /jobs/||p')
    while [ -n "$ID" ] && curl -sS "$url/jobs/$ID" | grep -qE '"state":"(queued|running)"'; do sleep 0.2; done
done <"$data/commands"

for client in "target/debug/examples/client" "python3 examples/client.py" "sh examples/plan.sh"; do
    echo "\$ $client"
    $client "$url" examples/meshes/duck.obj contacts=4 friction=0.5 seed=1 generations=5 | tee "$data/output"
    grep -q "^quality" "$data/output"
done
{
    sed -n '/^## Webhooks/,/^## API/p' docs/service.md | sed -n '/^```python$/,/^```$/p' | sed '/^```/d'
    cat <<'END'
secret, body = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw", b'{"test": 2432232314}'
headers = {
    "webhook-id": "msg_p5jXN8AQM9LWM0D4loKWxJek",
    "webhook-timestamp": "1614265330",
    "webhook-signature": "v1,AAAA v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=",
}
assert is_genuine(secret, headers, body, float("inf"))
assert not is_genuine(secret, headers, body), "stale"
assert not is_genuine(secret, headers, body + b" ", float("inf")), "changed"
END
} | python3 -

sh tests/client_restart.sh
echo "documented commands: all of them run"
