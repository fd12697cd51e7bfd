#!/bin/sh
# From mesh files to their results, a line of JSON each, with curl alone:
#
#     sh examples/batch.sh http://127.0.0.1:8080 '{"contacts": 4, "friction": 0.5}' examples/meshes/*.stl >results.ndjson
set -eu
[ $# -ge 3 ] || { echo "usage: batch.sh SERVER SETTINGS MESH..." >&2; exit 2; }
server=$1
settings=$2
shift 2

meshes=
for mesh do
    id=$(curl -sS --fail-with-body -F 'mesh=@-;filename=mesh' "$server/meshes" <"$mesh" |
        sed 's/^{"id":"\([0-9a-f]*\)".*/\1/')
    meshes="$meshes${meshes:+, }\"$id\""
done

path=$(curl -sS --fail-with-body -i --json "{\"meshes\": [$meshes], \"request\": $settings}" "$server/batches" |
    tr -d '\r' | sed -n 's/^[Ll]ocation: //p')
[ -n "$path" ] || { echo "the batch was not accepted" >&2; exit 1; }
echo "batch $server$path" >&2

# The server answers once the batch has ended, or after so many seconds.
while :; do
    batch=$(curl -sS --fail-with-body "$server$path?wait=20")
    echo "$batch" | sed 's/.*"jobs":{\([^}]*\)}.*/\1/' >&2
    case $batch in *'"state":"ended"'*) break ;; esac
done
curl -sS --fail-with-body "$server$path/results"
