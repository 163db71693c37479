# `make demo` shows what raylet does; `make quick` is for every save; `make test` runs everything that continuous
# integration runs.

OUT ?= out/demo
SCENE = scenes/hologram_through_lens.toml
RAYLET = cargo run --release --quiet --package raylet-cli --bin raylet --

.PHONY: demo quick test test-rust lint compiled cargo-test environments test-python test-torch fuzz bench instruction-counts performance accuracy real-size exact-fields huygens-psf cross-check aperture-scaling wheel docs

# Designs the hologram on the paraxial train, sends it through the real lens, leaves pictures and numbers.
demo:
	cargo build --release --package raylet-cli
	$(RAYLET) hologram $(SCENE)
	$(RAYLET) check $(SCENE)
	$(RAYLET) simulate $(SCENE) --out $(OUT)

# What a developer runs at every save: format, lints, the rules of the house, and the unit tests but for slow ones, whose
# names end with _slow.
quick:
	cargo fmt --all --check
	cargo clippy --profile quick --workspace --all-targets -- -D warnings
	cargo test --profile quick --quiet --workspace --lib --test house -- --skip _slow

# Lints work beside the compiler, in a folder of their own; the environments come mostly from the network.
test:
	$(MAKE) --no-print-directory --jobs 3 lint compiled environments
	$(MAKE) --no-print-directory cargo-test fuzz test-python test-torch

test-rust: lint compiled cargo-test

compiled:
	cargo test --release --workspace --tests --no-run

lint:
	cargo fmt --all --check
	cargo clippy --profile quick --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --profile quick --workspace --no-deps

# Examples that are no tests are only linted.
cargo-test:
	cargo test --release --workspace --tests
	cargo test --release --workspace --doc

# Random scenes, files and arguments (docs/fuzzing.md). A long run: make fuzz CASES=1000000; its last cases: FROM=990000.
CASES ?= 1000
SEED ?= 1
FROM ?= 0

# Processes that fuzz, or run Python tests, side by side: most of these keep one processor busy.
JOBS ?= 2
PYTEST = python -m pytest -n $(JOBS) --dist worksteal

# The whole workspace decides on features, so that what the tests built is not built again.
fuzz:
	cargo build --release --quiet --workspace --bin raylet
	$(PYTHON) -m fuzz --cases $(CASES) --seed $(SEED) --from $(FROM) --jobs $(JOBS)

# A virtual environment with what the Python tests need; the package is built with the same profile as the rest. Python
# compiles modules when they are first imported: to compile all of them takes as long as to install them.
VENV = .venv
PYTHON ?= python3

$(VENV)/ready: python/requirements-test.txt
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/pip install --quiet --disable-pip-version-check --no-compile -r python/requirements-test.txt
	touch $@

.PHONY: install
install: $(VENV)/ready
	PATH="$(CURDIR)/$(VENV)/bin:$$PATH" $(VENV)/bin/pip install --quiet --disable-pip-version-check \
		--no-build-isolation --no-deps --force-reinstall .

# The types of the extension module, written by the module itself.
STUBS = out/stubs/raylet/_raylet.pyi

.PHONY: stubs $(STUBS)
$(STUBS): $(VENV)/ready
	PATH="$(CURDIR)/$(VENV)/bin:$$PATH" $(VENV)/bin/maturin generate-stubs --quiet --profile release --out out/stubs
	$(VENV)/bin/ruff format --quiet $@
	$(VENV)/bin/ruff check --quiet --fix $@

# Remakes the stubs that the package carries.
stubs: $(STUBS)
	cp $(STUBS) python/raylet/_raylet.pyi

# Pages whose snippets the tests run one by one: continuous integration does not run them again for its site.
TESTED_PAGES = gallery_beams gallery_gratings gallery_imaging

test-python: install
	$(VENV)/bin/ruff format --check python fuzz benches
	$(VENV)/bin/ruff check python fuzz benches
	$(MAKE) --no-print-directory $(STUBS)
	cmp $(STUBS) python/raylet/_raylet.pyi || { echo "types have changed: run make stubs"; exit 1; }
	$(VENV)/bin/mypy
	$(VENV)/bin/python -m mypy.stubtest raylet._raylet
	$(VENV)/bin/$(PYTEST)
	RAYLET_TESTED_PAGES="$(TESTED_PAGES)" NO_MKDOCS_2_WARNING=1 $(VENV)/bin/mkdocs build --strict --quiet

# One wheel for every Python from 3.10 on.
WHEELS = out/wheels

wheel: $(VENV)/ready
	rm -rf $(WHEELS)
	PATH="$(CURDIR)/$(VENV)/bin:$$PATH" $(VENV)/bin/maturin build --release --quiet --out $(WHEELS)

# The wheel beside PyTorch and the ray tracers that need it. DeepLens needs Python 3.12; with another one its tests
# are skipped. PyTorch's wheel for Linux brings CUDA along: 7 GB on disk.
TORCH_VENV = .venv-torch
PYTHON_TORCH ?= $(firstword $(shell for p in python3.12 "$$HOME"/.pyenv/versions/3.12.*/bin/python3 $(PYTHON); do \
	"$$p" -c "" 2>/dev/null && echo "$$p"; done))
ROOM_GB = 10

$(TORCH_VENV)/ready: python/requirements-torch.txt
	$(PYTHON_TORCH) -m venv $(TORCH_VENV)
	$(TORCH_VENV)/bin/pip install --quiet --disable-pip-version-check --no-cache-dir --no-compile \
		-r python/requirements-torch.txt
	touch $@

# With PyTorch only where there is room for it.
environments: $(VENV)/ready
	@if [ ! -e $(TORCH_VENV)/ready ] && [ $$(df -Pk . | awk 'NR == 2 { print int($$4 / 1e6) }') -lt $(ROOM_GB) ]; \
	then echo "skipped: tests with PyTorch need $(ROOM_GB) GB of disk"; \
	else $(MAKE) --no-print-directory $(TORCH_VENV)/ready; fi

test-torch: environments wheel
	@if [ -e $(TORCH_VENV)/ready ]; then $(MAKE) --no-print-directory test-torch-here; fi

.PHONY: test-torch-here
test-torch-here:
	$(TORCH_VENV)/bin/pip install --quiet --disable-pip-version-check --no-deps --force-reinstall $(WHEELS)/*.whl
	$(TORCH_VENV)/bin/$(PYTEST) -m torch

# The guide as a site, in site/.
docs: install
	cargo build --release --package raylet-cli
	cargo doc --profile quick --package raylet --no-deps
	NO_MKDOCS_2_WARNING=1 $(VENV)/bin/mkdocs build --strict
	cp -R target/doc site/rust

bench:
	cargo bench --package raylet

# Counts the instructions of the hot loops anew, after a change that is meant to alter them (crates/raylet/benches/instructions).
instruction-counts:
	cargo test --release --workspace --test instructions -- --write

# Remakes docs/performance.md and its picture, beside other ray tracers.
performance: environments wheel
	$(TORCH_VENV)/bin/pip install --quiet --disable-pip-version-check --no-deps --force-reinstall $(WHEELS)/*.whl
	$(TORCH_VENV)/bin/python -m benches.peers.performance

# Remakes docs/huygens_psf.md, beside Optiland.
huygens-psf: environments wheel
	$(TORCH_VENV)/bin/pip install --quiet --disable-pip-version-check --no-deps --force-reinstall $(WHEELS)/*.whl
	$(TORCH_VENV)/bin/python benches/peers/huygens_psf.py

# Remakes docs/cross_check.md: methods side by side on random systems. SEED=n runs one system alone; RESUME=1 goes on with a
# run that was stopped.
SYSTEMS ?= 200
cross-check: install
	$(VENV)/bin/python -m benches.cross_check --systems $(SYSTEMS) $(if $(filter command line,$(origin SEED)),--seed $(SEED)) \
		$(if $(RESUME),--resume)

# Remakes docs/accuracy.md.
accuracy:
	cargo test --release --package raylet-accuracy --test integration -- --ignored
	cargo run --release --package raylet-accuracy > docs/accuracy.md

# Remakes docs/aperture_scaling.md and its picture.
aperture-scaling:
	cargo run --release --package raylet-accuracy --example aperture_scaling

# Remakes docs/real_size.md.
real-size:
	cargo run --release --package raylet-accuracy --example real_size > docs/real_size.md

# Remakes docs/exact_fields.md and its picture: a quarter of an hour of one core.
exact-fields:
	cargo run --release --package raylet-accuracy --example exact_fields
