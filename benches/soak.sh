#!/bin/sh
# soak.sh [MINUTES [JOBS-A-SECOND]]: tiny jobs for an hour, and each minute what the server takes: a Markdown
# table on standard output. Both must stay flat once retention has begun to forget; set it short by GRASPD_
# settings in the environment.
set -eu
cd "$(dirname "$0")/.."
minutes=${1:-60}
rate=${2:-50}
cargo build --quiet --release --locked --bin graspd
cargo bench --quiet --locked --bench load --no-run
. benches/server.sh
start_server
timeout $((minutes * 60 + 300)) cargo bench --quiet --locked --bench load -- "$url" soak $((minutes * 60)) "$rate" \
    >"$data/driver" 2>&1 &
driver=$!
echo "| minute | resident MB | data folder MB |"
echo "|---|---|---|"
minute=0
while [ $minute -lt "$minutes" ] && kill -0 $driver 2>/dev/null; do
    sleep 60
    minute=$((minute + 1))
    kill -0 $server || { echo "the server is gone" >&2; cat "$data/errors" >&2; exit 1; }
    resident=$(awk '/^VmRSS/ { print $2 / 1024 }' /proc/$server/status)
    echo "| $minute | $resident | $(du -sm "$data/server" | cut -f1) |"
done
wait $driver || { cat "$data/driver" >&2; exit 1; }
echo
cat "$data/driver"
