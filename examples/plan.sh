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

# The settings become form fields, in place of the arguments they came from.
for setting do
    set -- "$@" --form-string "$setting"
    shift
done

answer=$(curl -sS -i -F 'mesh=@-;filename=mesh' "$@" "$server/jobs" <"$mesh")
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
case $result in
    *'"force_closure":true'*) ;;
    *)
        printf '%s\n' "$result" | sed 's/.*"explanation":{[^}]*"detail":"\([^"]*\)".*/no force closure: \1/'
        exit 3
        ;;
esac
printf '%s\n' "$result" | sed 's/.*"quality":\([^,]*\),"margin".*/quality \1/'
printf '%s\n' "$result" | sed 's/"initial":.*//' | grep -o '"position":\[[^]]*\],"normal":\[[^]]*\]'
