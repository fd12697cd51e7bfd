#!/bin/sh
# Runs every command that the README and the book show behind a `$`, the README's Python and the clients, against a
# server of its own, and the Python of docs/service.md on the example of Standard Webhooks: documentation that does not
# run is wrong.
set -eu
cd "$(dirname "$0")/.."
sh tests/install.sh curl python3
. tests/binary.sh
. tests/server.sh
# What the documents call /var/lib/graspd is the folder of this server.
export GRASPD_DATA_DIR="$data/server"
start_server 127.0.0.1:0
export GRASPD_LISTEN="$address"

PATH=$(dirname "$binary"):$PATH
mkdir "$data/backup"
ID=
key_id=
for document in README.md docs/first-grasp.md docs/evaluations.md docs/command-line.md docs/constraints.md docs/meshes.md \
    docs/service.md docs/exports.md docs/batches.md docs/operations.md; do
    sed -n 's/^\$ //p' $document >"$data/commands"
    [ -s "$data/commands" ] || { echo "$document shows no command" >&2; exit 1; }
    while IFS= read -r command; do
        command=$(printf '%s' "$command" | sed "s/localhost:8080/$address/g; s/curl /curl --fail-with-body /
            s|/var/lib/graspd-new|$data/new|g; s|/var/lib/graspd|$data/server|g; s|/backup/|$data/backup/|g
            s/5f0c2a91d3b7/$key_id/g; s| -o grasp| -o $data/grasp|g; s| --output results| --output $data/results|g")
        echo "\$ $command"
        eval "$command" >"$data/output" </dev/null || { cat "$data/output" >&2; echo "failed: $command" >&2; exit 1; }
        cut -c1-200 "$data/output" | head -n 5
        # The walk-through goes on with the job of its first command, and with the key that was made.
        [ -n "$ID" ] || ID=$(tr -d '\r' <"$data/output" | sed -n 's|^[Ll]ocation: /jobs/||p')
        while [ -n "$ID" ] && curl -sS "$url/jobs/$ID" | grep -qE '"state":"(queued|running)"'; do sleep 0.2; done
        [ -n "$key_id" ] || key_id=$(graspd keys list --json | sed -n 's/^ *"id": "\(.*\)".*/\1/p')
    done <"$data/commands"
done
sed -n '/^```python$/,/^```$/p' README.md | sed "/^\`\`\`/d; s/localhost:8080/$address/; s/^job_id = .*/job_id = \"$ID\"/" | python3 -

for client in "$(dirname "$binary")/examples/client" "python3 examples/client.py" "sh examples/plan.sh"; do
    echo "\$ $client"
    $client "$url" examples/meshes/duck.obj contacts=4 friction=0.5 seed=1 generations=5 | tee "$data/output"
    grep -q "^quality" "$data/output"
done
for client in 'sh examples/batch.sh '"$url"' {"generations":5}' "python3 examples/batch.py $url generations=5"; do
    echo "\$ $client"
    $client examples/meshes/box.stl examples/meshes/duck.obj | tee "$data/output" | cut -c1-200
    [ "$(grep -c succeeded "$data/output")" = 2 ]
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
