#!/bin/sh
# Plans a grasp on one mesh of a list and writes one JSON file. Every task of a sweep runs this, under any engine.
#
#     plan_one.sh LIST INDEX OUT [FLAG]...
#
# LIST is a file with the path of one mesh per line; INDEX is the number of the line, from 0. The arguments after OUT
# are flags of `graspd plan`. If they contain no seed, --seed 1 is added, so that every result can be reproduced to the
# bit. The environment variable GRASPD names the program if it is not `graspd` on the path, and THREADS is its number
# of threads, which does not change the result.
#
# OUT/MESH.json is the result, under the path that the mesh has in LIST. It is never left half-written. If it exists
# and is no older than its mesh, nothing is done, so run everything again after an interruption. A mesh that cannot be
# planned leaves OUT/MESH.error with the reason, and is tried again by the next run. Results of other flags need
# another folder.
#
# Exit codes: 0 the JSON exists, with a grasp or with the reason why there is none; 1 the mesh cannot be used, or a
# file cannot be written; 2 the arguments cannot be used; anything else: the run was interrupted, so try again.
set -eu
refuse() {
    echo "plan_one.sh: $1" >&2
    exit 2
}
[ $# -ge 3 ] || refuse "usage: plan_one.sh LIST INDEX OUT [FLAG]..."
list=$1
index=$2
out=$3
shift 3
case $index in
    '' | *[!0-9]*) refuse "INDEX must be a whole number from 0, not '$index'" ;;
esac
[ -r "$list" ] || refuse "the list $list cannot be read"
mesh=$(sed -n "$((index + 1))p" "$list")
[ -n "$mesh" ] || refuse "$list has no mesh in line $((index + 1))"
case /$mesh/ in
    */../*) refuse "the result of $mesh would be outside $out: list it without '..'" ;;
esac
case " $* " in
    *" --seed "* | *" --seed="*) ;;
    *) set -- "$@" --seed 1 ;;
esac

result=$out/${mesh#/}.json
error=$out/${mesh#/}.error
mkdir -p "$(dirname "$result")"
# On the file system of the results, so that renaming is atomic.
new=$(mktemp -d "$out/.new-XXXXXX")
plan=
end() {
    if [ -n "$plan" ]; then
        kill "$plan" 2>/dev/null || true
        wait "$plan" || true
    fi
    exit "$1"
}
trap 'rm -rf "$new"' EXIT
trap 'end 130' INT
trap 'end 143' TERM

printf '%s\n' "$@" >"$new/flags"
cp "$new/flags" "$new/mine"
[ -e "$out/flags" ] || mv "$new/flags" "$out/flags"
cmp -s "$new/mine" "$out/flags" || refuse "$out has results of other flags, those in $out/flags: name another folder"
if [ -e "$result" ] && [ ! "$mesh" -nt "$result" ]; then
    echo "$mesh: done before"
    exit 0
fi

# In the background: a shell that waits for a program in the foreground handles no signal.
"${GRASPD:-graspd}" plan "$mesh" --json ${THREADS:+--threads "$THREADS"} "$@" >"$new/json" 2>"$new/error" &
plan=$!
code=0
wait "$plan" || code=$?
case $code in
    0) outcome=planned ;;
    3) outcome="planned, there is no force closure" ;;
    *)
        cat "$new/error" >&2
        echo "$mesh: exit code $code" | tee -a "$new/error" >&2
        mv "$new/error" "$error"
        exit "$code"
        ;;
esac
mv "$new/json" "$result"
rm -f "$error"
echo "$mesh: $outcome"
