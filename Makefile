# The commands of README and of the book. Everything is built in the dev profile, in which the hot paths are optimised (Cargo.toml), so that
# `make test` reuses what `make demo` has built.

WHEREIN = target/debug/wherein
PYTHON ?= python3
DEMO_SCENE = scenes/home.toml
# The oldest compiler that is supported, as Cargo.toml states it.
MSRV = 1.89
# Keeps Mesa's device selection layer from asking for a display, which a headless machine does not have.
export NODEVICE_SELECT = 1

.PHONY: help demo test test-long lint bench bench-render photon-transfer allan path-traced readers golden gallery experiments straight-drive falsify falsify-scenes falsify-boxes power sharpness python test-python ray test-ray driver build \
	many-cases container container-root test-container msrv features deny package book site archive check-tag release-notes

help:
	@echo "make demo          run the main scene and show its results and pictures"
	@echo "make test          run all tests"
	@echo "make test-long     run all tests at full length, with those that take a minute or more"
	@echo "make lint          formatting, clippy and documentation, warnings refused"
	@echo "make bench         measure speed, and memory over a drive of 100 000 steps"
	@echo "make bench-render  render a room, and a like one with MuJoCo where Python has it"
	@echo "make photon-transfer  analyse the sensor by the package emva1288 where Python has it; PYTHON=…"
	@echo "make readers       let programs of others read what runs leave, where Python has them; PYTHON=…"
	@echo "make allan         analyse the gyroscope by the package allantools where Python has it; PYTHON=…"
	@echo "make golden        take the pictures anew against which tests compare; look at them"
	@echo "make gallery       take the film and all pictures of the book anew; look at them"
	@echo "make path-traced   compare the light of five scenes with the path tracer Mitsuba where Python has it; PYTHON=…"
	@echo "make experiments   rerun the long tables of the book and of README; ISSUE=N for one group only"
	@echo "make straight-drive  rerun paper 4's numerical experiment and put its tables and figure into the book: two minutes"
	@echo "make falsify       10⁷ values and 10⁸ rigid motions against the interval engine, 10⁷ rows of each kind, 10⁷ problems of P3P, 900 pairs of images: 2 hours"
	@echo "make falsify-scenes  random scenes against the promise, other ones each time; MINUTES=N, SEED=N, FLAGS=…"
	@echo "make falsify-boxes  random scenes in which other histories than the true one must be in the boxes, too; MINUTES=N, SEED=N, FLAGS=…"
	@echo "make sharpness     how much of the boxes' width the readings leave open, in each scene of the experiments; half an hour"
	@echo "make power         six scenes with errors at their corners and in a drift: how much of the boxes they use; 40 minutes"
	@echo "make python        build the Python package as a wheel; PYTHON=…"
	@echo "make test-python   test the Python package and its examples; PYTHON=…"
	@echo "make test-ray      test sweeps on a Ray cluster of nodes on this machine, where Python has ray; PYTHON=…"
	@echo "make ray           sweep on such a cluster with killed nodes, and measure what Ray costs: half an hour; PYTHON=…"
	@echo "make many-cases    report on 10⁶ made-up cases: figures, time and memory; 10 minutes; PYTHON=…"
	@echo "make container     build the image of a container with the command, by podman, buildah or docker; scripts/container"
	@echo "make container-root  the same from base images made by debootstrap, where no registry of images is reached; as root"
	@echo "make test-container  run a scene in the image, and check its size; 250 MB at most"
	@echo "make driver        install a software Vulkan driver where no adapter is found"
	@echo "make msrv          check all crates with the oldest compiler that is supported"
	@echo "make features      check the crates with each set of features"
	@echo "make deny          check licences, advisories and doubles of the dependencies by cargo-deny"
	@echo "make package       package the crates for a registry, without publishing them"
	@echo "make book          make the book by mdBook in target/book, warnings refused"
	@echo "make site          make the book and the documentation of the crates in target/site"
	@echo "make archive       build the command for this system into an archive in target/archives"
	@echo "make check-tag     check that the crates and the changelog have the version of a tag; TAG=v…"
	@echo "make release-notes print what the changelog says of a version; TAG=v…"

demo: driver build
	$(WHEREIN) run $(DEMO_SCENE) --frames every=25 --out renders
	@echo "Pictures: renders/home/0/errands.png and renders/home/0/figure_*.png"

test: driver
	cargo test --locked --workspace

# All tests with those that are ignored otherwise, and as many rounds, seeds and scenes as the tests know.
test-long: driver
	WHEREIN_LONG=1 cargo test --locked --workspace -- --include-ignored

lint:
	cargo fmt --all --check
	cargo clippy --locked --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS=-Dwarnings cargo doc --locked --workspace --no-deps

bench: driver
	cargo bench --locked --profile dev -p wherein-interval --bench interval
	cargo bench --locked --profile dev -p wherein-interval --bench linear_program
	cargo bench --locked --profile dev -p wherein-localizer --bench p3p
	cargo bench --locked --profile dev -p wherein-localizer --bench point_features
	cargo bench --locked --profile dev -p wherein-localizer --bench rigid_motion
	cargo bench --locked --profile dev -p wherein-tests --bench speed
	cargo bench --locked --profile dev -p wherein-tests --bench endurance

bench-render: driver
	cargo bench --locked --profile dev -p wherein-tests --bench speed -- views | tee target/bench_render.txt
	$(PYTHON) scripts/bench_render target/bench_render.txt

photon-transfer: driver
	cargo run --locked -p wherein-tests --example photon_transfer target/photon_transfer
	$(PYTHON) scripts/photon_transfer target/photon_transfer

readers: driver
	cargo build --locked -p wherein-sim --features parquet
	$(PYTHON) scripts/outside_readers $(WHEREIN) target/readers

many-cases: driver
	cargo build --locked --workspace --bins --example many_cases --features wherein-tests/parquet
	$(PYTHON) scripts/many_cases target/debug/examples/many_cases $(WHEREIN) target/many_cases

allan:
	cargo run --locked -p wherein-tests --example allan target/allan
	$(PYTHON) scripts/allan target/allan

golden: driver
	WHEREIN_GOLDEN=1 cargo test --locked -p wherein-tests --test it golden_images

gallery: driver build
	scripts/gallery $(WHEREIN)

path-traced:
	cargo run --locked -p wherein-tests --example path_traced target/path_traced
	$(PYTHON) scripts/path_traced target/path_traced

experiments: driver build allan $(if $(ISSUE),,test-long)
	scripts/experiments $(ISSUE)

straight-drive:
	cargo run --locked -p wherein-localizer --example straight_drive target/straight_drive
	$(PYTHON) scripts/straight_drive target/straight_drive/results.csv

falsify:
	WHEREIN_INTERVAL_TRIALS=14000000 WHEREIN_RIGID_TRIALS=100000000 \
		cargo test --locked -p wherein-tests --test it -- --nocapture interval_precision contractor_falsification
	WHEREIN_PROGRAMS=1000000 cargo test --locked -p wherein-interval --lib -- --nocapture solver
	WHEREIN_ROWS=167 cargo test --locked -p wherein-localizer --lib -- --nocapture graph::sighting graph::flow graph::way graph::link
	WHEREIN_ROWS=500 cargo test --locked -p wherein-localizer --lib -- --nocapture relate mapped_landmarks::tests::the_truth mapped_landmarks::tests::a_landmark
	WHEREIN_P3P_PROBLEMS=10000000 cargo test --locked -p wherein-localizer --lib -- --nocapture p3p
	WHEREIN_FEATURE_PAIRS=60 cargo test --locked -p wherein-localizer --lib -- --nocapture point_features

# The default seed of a search is the time in seconds since 1970, which no earlier search had. make prints the command, so that the same
# search can be repeated.
SEED ?= $(shell date +%s)
MINUTES ?= 10
falsify-scenes: driver build
	$(WHEREIN) falsify --seed $(SEED) --minutes $(MINUTES) $(FLAGS)

# Histories other than the true one that keep every bound have to be in the boxes, too.
falsify-boxes: driver build
	$(WHEREIN) falsify --seed $(SEED) --minutes $(MINUTES) --wish witness_outside --wish unsound --out renders/falsify_boxes $(FLAGS)

sharpness: driver build
	$(PYTHON) scripts/sharpness --wherein $(WHEREIN)

power: driver build
	$(PYTHON) scripts/power --wherein $(WHEREIN)

# Both make their virtual environments in target/python themselves.
python:
	@PYTHON=$(PYTHON) scripts/python build

test-python: driver
	@PYTHON=$(PYTHON) scripts/python test

test-ray: driver build
	WHEREIN=$(WHEREIN) $(PYTHON) -m pytest python/tests/test_ray.py

ray: driver build
	$(PYTHON) scripts/ray_trial --wherein $(WHEREIN)

driver:
	@scripts/driver

build:
	cargo build --locked --workspace --bins

msrv:
	rustup toolchain install $(MSRV) --profile minimal
	cargo +$(MSRV) check --locked --workspace --all-targets

features:
	cargo check --locked -p wherein-interval
	cargo check --locked -p wherein-interval --no-default-features
	cargo check --locked -p wherein-interval --no-default-features --features serde
	cargo check --locked -p wherein-localizer
	cargo check --locked -p wherein-localizer --no-default-features
	cargo check --locked -p wherein-localizer --no-default-features --features serde
	cargo check --locked -p wherein-localizer --no-default-features --features vision
	cargo check --locked -p wherein-sim
	cargo check --locked -p wherein-sim --no-default-features
	cargo check --locked -p wherein-sim --no-default-features --features live
	cargo check --locked -p wherein-sim --no-default-features --features man
	cargo check --locked -p wherein-sim --no-default-features --features parquet
	cargo check --locked -p wherein-python

deny:
	cargo deny --locked check

# The crates depend on each other, so that they are packaged together.
package:
	cargo package --locked -p wherein-interval -p wherein-localizer -p wherein-sim

# mdBook ends with 0 although it has warned.
book:
	@mkdir -p target
	mdbook build docs --dest-dir $(CURDIR)/target/book 2> target/book.log || { cat target/book.log; exit 1; }
	@cat target/book.log
	@! grep -q WARN target/book.log

site: book
	RUSTDOCFLAGS=-Dwarnings cargo doc --locked --workspace --no-deps
	rm -rf target/site
	cp -R target/book target/site
	cp -R target/doc target/site/api

container:
	@scripts/container build

container-root:
	@scripts/container bases

test-container:
	@scripts/container try

archive:
	@scripts/release archive

check-tag:
	@scripts/release check $(TAG)

release-notes:
	@scripts/release notes $(TAG)
