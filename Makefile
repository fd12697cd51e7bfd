.PHONY: run check test book page page-if-node otel meshes openapi answers bench agreement instructions fuzz planner reproduce chaos fleet coordination conformance load soak

# Builds, starts a server on its embedded store, plans a grasp on the duck over HTTP and shows it.
run: page-if-node
	cargo build --release --locked --bin graspd
	sh examples/demo.sh

# The page for people, which becomes part of the binary.
page: web/dist/page/index.html

web/dist/page/index.html: web/node_modules web/index.html web/vite.config.ts web/tsconfig.json \
    $(shell find web/src web/public -type f) $(wildcard examples/meshes/*.*)
	npm --prefix web run build

web/node_modules: web/package.json web/package-lock.json
	npm --prefix web ci --no-audit --no-fund
	touch web/node_modules

# The same where Node is new enough; without it the server is as good, and says at / how to get the page.
page-if-node:
	@if node -e 'const [a, b] = process.versions.node.split("."); process.exit(a > 20 || (a == 20 && b >= 19) ? 0 : 1)' 2>/dev/null; then \
	    $(MAKE) page; \
	else \
	    echo "No Node 20.19 or newer here: the page is left out, all else is built."; \
	fi

# The quick gate: format, lints and unit tests.
check:
	sh tests/install.sh libclang
	cargo fmt --all --check
	cargo clippy --locked --workspace --all-targets -- -D warnings
	cargo test --locked --workspace --lib

# Everything that a change has to pass; tests/run.py says what. GRASPD_ALLOW_SKIP=1 lets the tests be skipped that
# mount a disk or make a network of their own, which takes root.
test:
	sh tests/install.sh python3
	@exec python3 tests/run.py

# Kills the server 200 times under load and ends it 100 times, a few minutes each; without the numbers it is
# the short form that is part of the tests.
chaos:
	GRASPD_KILLS=200 GRASPD_TERMS=100 cargo test --locked --test chaos -- --nocapture --test-threads 1

# The long form of the tests of many servers and workers on one database: 2,000 jobs in great disorder, 1,000
# clients who follow; a quarter of an hour.
fleet:
	GRASPD_FLEET_JOBS=2000 GRASPD_FOLLOWERS=1000 cargo test --locked --test fleet -- --nocapture --test-threads 1

# What coordination costs with 64 workers whose planner only waits; wants an idle machine.
coordination:
	cargo bench --locked --bench fleet

# Renders docs/ as a book into target/book and checks its links.
book:
	sh tests/book.sh

# The feature otel, whose dependencies not everyone wants to compile.
otel:
	cargo clippy --locked --all-targets --features otel -- -D warnings
	cargo test --locked --features otel --test http -- otel::

# Holds a server against its description with several thousand requests.
conformance:
	GRASPD_PHASES=examples,coverage,fuzzing,stateful GRASPD_EXAMPLES=50 sh tests/conformance.sh

# Measures how the service takes load, for docs/load.md; wants an idle machine.
load:
	sh benches/load.sh

# Tiny jobs for an hour, and what the server takes each minute; fails when that grows.
soak:
	GRASPD_RETENTION=5m sh benches/soak.sh

# Makes the example meshes again; they are the same to the byte.
meshes:
	cargo run --release --locked --example make_meshes -- examples/meshes

# Writes again what follows from the code: the OpenAPI description, the reference of the settings, and the page's settings and types.
openapi: web/node_modules
	cargo run --locked -- openapi --output openapi/openapi.json
	cargo run --locked -- reference
	npm --prefix web run types

# Writes the snapshots of the service's answers again; read their diff.
answers:
	INSTA_UPDATE=always cargo test --locked --test answers

# Measures the quality engine beside Qhull and writes docs/quality.md and its picture; GRASPD_MESHES names
# a folder with the meshes of the paper, see crates/testkit/src/cases.rs. Wants an idle machine.
bench:
	sh tests/install.sh libclang
	cargo bench --locked -p qhull-comparison -- --write $(CURDIR)/docs
	command -v rsvg-convert || { apt-get update && apt-get install --yes librsvg2-bin; }
	rsvg-convert --zoom 1.5 docs/quality-growth.svg --output docs/quality-growth.png

# Runs the paper's experiments again and writes docs/reproduction.
reproduce:
	cargo run --release --locked --bin graspd -- reproduce --runs 10 --output docs/reproduction

# Measures the searches on the paper's cases and writes docs/planner.md; GRASPD_MESHES, GRASPD_SEEDS and
# GRASPD_LONG as in benches/planner/main.rs. Wants an idle machine.
planner:
	cargo bench --locked --bench planner -- --write docs

# Compares the quality engine with Qhull on 110,000 grasps: a quarter of an hour.
agreement:
	sh tests/install.sh libclang
	GRASPD_AGREEMENT=110000 cargo test --locked --release -p qhull-comparison -- --nocapture

# Counts the instructions of standard evaluations.
instructions:
	sh benches/instructions.sh

# Odd wrench sets for half an hour, then odd files for each reader and odd triangles, 21 minutes each; needs
# cargo-fuzz and the nightly toolchain.
fuzz:
	cargo +nightly fuzz run wrench_sets -- -max_total_time=1800 -timeout=100 -max_len=1024
	for target in read_stl read_obj read_ply read_off read_gltf read_3mf read_dae prepare; do \
	    cargo +nightly fuzz run $$target -- -max_total_time=1260 -timeout=60 -max_len=4096 || exit 1; \
	done
