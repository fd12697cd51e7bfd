.PHONY: run test meshes openapi

# Builds, starts a server on its embedded store, plans a grasp on the duck over HTTP and shows it.
run:
	cargo build --release --locked --bin graspd --example client
	sh examples/demo.sh

# Everything that a change has to pass.
test:
	cargo fmt --check
	cargo check --locked --lib --no-default-features
	cargo clippy --locked --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps --document-private-items
	cargo test --locked --all-targets
	cargo test --locked --doc
	sh tests/documented_commands.sh

# Makes the example meshes again; they are the same to the byte.
meshes:
	cargo run --release --locked --no-default-features --example make_meshes -- examples/meshes

# Writes the OpenAPI description again, after a change of the HTTP interface.
openapi:
	cargo run --locked -- openapi --output openapi/openapi.json
