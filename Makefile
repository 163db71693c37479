# `make demo` shows what raylet does; `make test` runs everything that continuous integration runs.

OUT ?= out/demo
SCENE = scenes/hologram_through_lens.toml
RAYLET = cargo run --release --quiet --package raylet-cli --bin raylet --

.PHONY: demo test bench accuracy

# Designs the hologram on the paraxial train, sends it through the real lens, leaves pictures and numbers.
demo:
	cargo build --release --package raylet-cli
	$(RAYLET) hologram $(SCENE)
	$(RAYLET) check $(SCENE)
	$(RAYLET) simulate $(SCENE) --out $(OUT)

test:
	cargo fmt --all --check
	cargo clippy --release --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --release --workspace --no-deps
	cargo test --release --workspace

bench:
	cargo bench --package raylet

# Remakes docs/accuracy.md.
accuracy:
	cargo run --release --package raylet-accuracy > docs/accuracy.md
