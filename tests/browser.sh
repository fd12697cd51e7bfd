#!/bin/sh
# Opens the pages in a real browser: they must be whole, and break no rule of their content security
# policy.
set -eu
cd "$(dirname "$0")/.."
command -v chromium >/dev/null || { apt-get update && apt-get install --yes --no-install-recommends chromium; }
cargo build --locked --bin graspd

. tests/server.sh
start_server 127.0.0.1:0

# Puts the page as the browser has built it into $data/page, and what it complains about into $data/said.
open() {
    rm -rf "$data/profile"
    timeout 120 chromium --headless --no-sandbox --disable-gpu --disable-quic --no-first-run \
        --disable-background-networking --disable-component-update --disable-sync --disable-dev-shm-usage \
        --user-data-dir="$data/profile" --virtual-time-budget=20000 --enable-logging=stderr --v=0 \
        --dump-dom "$1" >"$data/page" 2>"$data/said" ||
        { echo "chromium cannot open $1" >&2; tail -n 20 "$data/said" >&2; exit 1; }
}
refuses() { grep -qiE 'Content[- ]Security[- ]Policy|Refused to|violates the following' "$data/said"; }
shows() { grep -qF "$1" "$data/page" || { echo "$page does not show $1" >&2; head -c 3000 "$data/page" >&2; exit 1; }; }

# A page that breaks its policy must be noticed, or the rest proves nothing.
cat >"$data/broken.html" <<'END'
<meta http-equiv="Content-Security-Policy" content="default-src 'none'"><style>p{color:red}</style><p>broken
END
open "file://$data/broken.html"
refuses || { echo "the browser does not tell of violations" >&2; cat "$data/said" >&2; exit 1; }

for page in / /docs/; do
    open "$url$page"
    ! refuses || { echo "$page breaks its policy:" >&2; grep -iE 'policy|refused|violates' "$data/said" >&2; exit 1; }
    case $page in
    /) shows '<h1>graspd</h1>' ;;
    # Made by the scripts, from the description.
    /docs/)
        for operation in submit_job read_result evaluate upload_mesh preview_mesh healthz; do
            shows "$operation"
        done
        ;;
    esac
done
echo "browser: the pages are whole and keep to their policy"
