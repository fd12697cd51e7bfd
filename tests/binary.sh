# Sets $binary to the program under test; to be sourced at the top of the repository. It is the one that
# GRASPD_BINARY names, as tests/run.py does, or else is built from the same units as the tests, with the examples
# in the folder beside it.
binary=${GRASPD_BINARY:-}
if [ -z "$binary" ]; then
    cargo build --locked --workspace --bins --examples
    binary=$PWD/target/debug/graspd
fi
# `graspd doctor` complains of variables that it does not know.
unset GRASPD_BINARY
