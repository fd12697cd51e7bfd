#!/bin/sh
# Opens the page and the documentation in a real browser and uses them as a reader does: web/tests/*.js, each
# with servers of its own. With names of such files only these are run, without .js: sh tests/browser.sh docs
set -eu
cd "$(dirname "$0")/.."
sh tests/install.sh chromium
make page
. tests/binary.sh
export GRASPD_BINARY="$binary"

[ $# -gt 0 ] || set -- $(cd web/tests && ls ./*.js)
for name; do
    set -- "$@" "web/tests/${name%.js}.js"
    shift
done
# Whatever hangs ends; the machine may be doing much else.
exec node --test --test-concurrency=1 --test-timeout=900000 --test-reporter=spec "$@"
