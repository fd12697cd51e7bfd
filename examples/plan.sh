#!/bin/sh
# From a mesh file to printed contacts, with curl alone:
#
#     sh examples/plan.sh http://127.0.0.1:8080 examples/meshes/duck.obj contacts=4 friction=0.5
#
# Everything after the file is a planning setting, sent as a field of the form.
set -eu
[ $# -ge 2 ] || { echo "usage: plan.sh SERVER MESH [NAME=VALUE]..." >&2; exit 2; }
server=$1
mesh=$2
shift 2

# The settings become -F options, in place of the arguments they came from.
for setting do
    set -- "$@" -F "$setting"
    shift
done

answer=$(curl -sS -i -F "mesh=@$mesh" "$@" "$server/jobs")
path=$(printf '%s' "$answer" | tr -d '\r' | sed -n 's/^[Ll]ocation: //p')
if [ -z "$path" ]; then
    printf '%s\n' "$answer" >&2
    exit 1
fi
echo "job $server$path"

while :; do
    job=$(curl -sS "$server$path")
    state=$(printf '%s' "$job" | sed 's/.*"state":"\([a-z]*\)".*/\1/')
    case $state in
        queued | running) echo "$state"; sleep 1 ;;
        *) break ;;
    esac
done
[ "$state" = succeeded ] || { printf '%s\n' "$job" >&2; exit 1; }

result=$(curl -sS "$server$path/result")
printf '%s\n' "$result" | sed 's/.*"quality":\([^,]*\),.*"margin":\([^,]*\),.*/quality \1/;q' | cut -c1-80
printf '%s\n' "$result" | sed 's/"initial":.*//' | grep -o '"position":\[[^]]*\],"normal":\[[^]]*\]'
