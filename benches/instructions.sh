#!/bin/sh
# Instructions per evaluation, counted by valgrind: the same on a noisy machine. What comes before the
# evaluations is taken off by counting twice. Valgrind knows AVX2 but not AVX-512.
set -eu
cd "$(dirname "$0")/.."
sh tests/install.sh valgrind
host=$(rustc -vV | sed -n 's/^host: //p' | tr 'a-z-' 'A-Z_')
export "CARGO_TARGET_${host}_RUNNER=valgrind --tool=callgrind --callgrind-out-file=/dev/null"
cargo bench --quiet --locked --bench instructions --no-run

count() {
    cargo bench --quiet --locked --bench instructions -- "$1" "$2" 2>&1 |
        sed -n 's/.*Collected : \([0-9]*\).*/\1/p'
}

for case in 4x8 4x8-mid-search 5x16 7 7-batched; do
    few=$(count $case 2)
    many=$(count $case 22)
    # Twenty passes over sixteen grasps.
    echo "$case: $(((many - few) / 320)) instructions per evaluation"
done
