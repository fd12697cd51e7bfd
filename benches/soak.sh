#!/bin/sh
# soak.sh [MINUTES [JOBS-A-SECOND]]: tiny jobs for an hour, and each minute what the server takes: a Markdown
# table on standard output. Fails when the last quarter takes more than 1.5 times what the second did, by when
# retention has to have begun to forget: `make soak` sets it short enough for an hour.
set -eu
cd "$(dirname "$0")/.."
minutes=${1:-60}
rate=${2:-50}
[ "$minutes" -ge 4 ] || { echo "at least 4 minutes are wanted" >&2; exit 2; }
cargo build --quiet --release --locked --bin graspd
cargo bench --quiet --locked --bench load --no-run
binary=$PWD/target/release/graspd
. tests/server.sh
start_server 127.0.0.1:0 --log-level error --queue-capacity 1000000
timeout $((minutes * 60 + 300)) cargo bench --quiet --locked --bench load -- "$url" soak $((minutes * 60)) "$rate" \
    >"$data/driver" 2>&1 &
driver=$!
echo "| minute | resident MB | data folder MB |"
echo "|---|---|---|"
minute=0
while [ $minute -lt "$minutes" ] && kill -0 $driver 2>/dev/null; do
    sleep 60
    minute=$((minute + 1))
    kill -0 "$server" || { echo "the server is gone" >&2; cat "$data/errors" >&2; exit 1; }
    resident=$(awk '/^VmRSS/ { print $2 / 1024 }' "/proc/$server/status")
    echo "| $minute | $resident | $(du -sm "$data/server" | cut -f1) |" | tee -a "$data/table"
done
wait $driver || { cat "$data/driver" >&2; exit 1; }
echo
cat "$data/driver"
awk -F '|' -v minutes="$minutes" '
    $2 > minutes / 4 && $2 <= minutes / 2 { early++; resident += $3; folder += $4 }
    $2 > minutes * 3 / 4 { late++; late_resident += $3; late_folder += $4 }
    END {
        if (!early || !late) { print "the soak ended early" > "/dev/stderr"; exit 1 }
        memory = late_resident / late / (resident / early)
        disk = late_folder / late / (folder / early)
        printf "\nlast quarter to second: resident memory %.2f, data folder %.2f\n", memory, disk
        exit memory > 1.5 || disk > 1.5
    }' "$data/table"
