#!/bin/sh
# Opens what a server exports in programs of others: the Khronos validator and trimesh for GLB, trimesh for STL and
# PLY, PyYAML for isaac_grasp; and checks that all of them hold the same grasp. The validator is one of the page's
# packages.
set -eu
cd "$(dirname "$0")/.."
sh tests/install.sh venv
[ -d web/node_modules/gltf-validator ] || npm --prefix web ci --no-audit --no-fund
. tests/binary.sh
. tests/server.sh
start_server 127.0.0.1:0
mkdir "$data/files"
target/python/bin/python tests/exports.py "$url" "$data/files"

# A validator that finds fault with nothing proves nothing.
head -c 2000 "$data/files/soft.glb" >"$data/broken.glb"
cat >"$data/validate.cjs" <<'END'
const fs = require("node:fs");
const validator = require(process.argv[2]);
(async () => {
  let faults = 0;
  for (const file of process.argv.slice(3)) {
    const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
    faults += issues.numErrors + issues.numWarnings;
    for (const { severity, code, message, pointer } of issues.messages)
      if (severity < 2) console.error(file, code, message, pointer);
  }
  process.exit(faults ? 1 : 0);
})();
END
validate() { node "$data/validate.cjs" "$PWD/web/node_modules/gltf-validator" "$@"; }
! validate "$data/broken.glb" 2>/dev/null || { echo "the validator finds no fault with half a file" >&2; exit 1; }
set -- "$data"/files/*.glb
validate "$@"
echo "exports: others read them; the validator has no complaint about $# GLB files"
