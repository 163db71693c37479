# `make demo` shows what raylet does; `make test` runs everything that continuous integration runs.

OUT ?= out/demo
SCENE = scenes/hologram_through_lens.toml
RAYLET = cargo run --release --quiet --package raylet-cli --bin raylet --

.PHONY: demo test test-rust test-python test-torch bench accuracy wheel docs

# Designs the hologram on the paraxial train, sends it through the real lens, leaves pictures and numbers.
demo:
	cargo build --release --package raylet-cli
	$(RAYLET) hologram $(SCENE)
	$(RAYLET) check $(SCENE)
	$(RAYLET) simulate $(SCENE) --out $(OUT)

test: test-rust test-python

test-rust:
	cargo fmt --all --check
	cargo clippy --release --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --release --workspace --no-deps
	cargo test --release --workspace

# A virtual environment with what the Python tests need; the package is built with the same profile as the rest.
VENV = .venv
PYTHON ?= python3

$(VENV)/ready: python/requirements-test.txt
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/pip install --quiet --disable-pip-version-check -r python/requirements-test.txt
	touch $@

.PHONY: install
install: $(VENV)/ready
	PATH="$(CURDIR)/$(VENV)/bin:$$PATH" $(VENV)/bin/pip install --quiet --disable-pip-version-check \
		--no-build-isolation --no-deps --force-reinstall .

test-python: install
	$(VENV)/bin/ruff format --check python
	$(VENV)/bin/ruff check python
	$(VENV)/bin/mypy
	$(VENV)/bin/python -m mypy.stubtest raylet._raylet
	$(VENV)/bin/python -m pytest
	NO_MKDOCS_2_WARNING=1 $(VENV)/bin/mkdocs build --strict --quiet

# The same with PyTorch, which takes minutes to fetch.
test-torch: install
	$(VENV)/bin/pip install --quiet --disable-pip-version-check -r python/requirements-torch.txt
	$(VENV)/bin/python -m pytest

# One wheel for every Python from 3.10 on.
wheel: $(VENV)/ready
	$(VENV)/bin/maturin build --release --out out/wheels

# The guide as a site, in site/.
docs: install
	NO_MKDOCS_2_WARNING=1 $(VENV)/bin/mkdocs build --strict

bench:
	cargo bench --package raylet

# Remakes docs/accuracy.md.
accuracy:
	cargo run --release --package raylet-accuracy > docs/accuracy.md
