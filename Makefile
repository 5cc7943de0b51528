# Builds volgrad's C library and the renderer made of it, and runs everything that checks them.
#
#   make deps       installs what is missing (Debian, Ubuntu); names what is needed elsewhere
#   make            build/libvolgrad.a and build/volgrad-render
#   make demo       deps, and one scene with and without shifts in the same time: under three minutes
#   make test       all tests, and a short comparison with the reference images
#   make validate   the long comparison, and the long statistical tests
#   make bench      times line integrals, paths and shifts, writes tables in README.md and demo/costs.png; BENCH_FLAGS=--quick for a look
#   make peers      measures whole renders beside Mitsuba 3 for half an hour (MINUTES=28), writes the table in README.md
#   make chains     measures Metropolis chains with and without shifts for a few minutes, writes the table in README.md
#   make figures    the thesis' figures again and beyond, for forty minutes on two cores: build/figures/figures.html and README.md's part;
#                   TIME=minutes, RES=pixels (128 divided or multiplied by a whole number); goes on where it was stopped
#   make header     writes include/volgrad.h anew
#
# CARGO_TARGET_DIR and BUILD say where results go, CFLAGS and LDFLAGS are added to ours.

BUILD ?= build
TARGET := $(or $(CARGO_TARGET_DIR),target)
PYTHON ?= python3
VENV := $(BUILD)/venv
PY := $(VENV)/bin/python

FEATURES := ffi,exr
LIBRARY := $(BUILD)/libvolgrad.a
RENDER := $(BUILD)/volgrad-render
SCENES := $(wildcard scenes/*.xml)

PACKAGES := assimp expat libpng zlib
EMBREE = $(shell $(CC) $(CPPFLAGS) -E -x c -include embree4/rtcore.h /dev/null >/dev/null 2>&1 && echo embree4 || echo embree3)
C_FLAGS = -std=c11 -ffp-contract=off -Wall -Wextra -Wpedantic -Iinclude $(CPPFLAGS) $(shell pkg-config --cflags $(PACKAGES)) $(CFLAGS)
C_LIBS = $(shell pkg-config --libs $(PACKAGES)) -l$(EMBREE) -lpthread -ldl -lm $(LDFLAGS)

HOST := $(wildcard examples_c/render/*.c)
HOST_HEADERS := $(wildcard examples_c/render/*.h) include/volgrad.h
OBJECTS := $(HOST:examples_c/render/%.c=$(BUILD)/render/%.o)

REPLAY := $(BUILD)/volgrad-replay
RECORD := examples_c/record/record.c examples_c/record/mutation.c
RECORD_HEADERS := $(wildcard examples_c/record/*.h)
RECORD_OBJECTS := $(RECORD:examples_c/record/%.c=$(BUILD)/record/%.o)

.PHONY: all deps demo test validate bench peers chains figures header clean test-rust test-c test-record test-cli test-scenes FORCE
.DELETE_ON_ERROR:

all: $(LIBRARY) $(RENDER) $(REPLAY)

# ---- library and renderer ----

# Cargo knows whether there is something to do.
$(TARGET)/release/libvolgrad.a: FORCE
	cargo rustc --release --lib --features $(FEATURES) --crate-type staticlib

$(LIBRARY): $(TARGET)/release/libvolgrad.a | $(BUILD)
	cp -p $< $@

$(BUILD)/render/%.o: examples_c/render/%.c $(HOST_HEADERS) | $(BUILD)/render
	$(CC) $(C_FLAGS) -O2 -c $< -o $@

$(RENDER): $(OBJECTS) $(RECORD_OBJECTS) $(LIBRARY)
	$(CC) $^ $(C_LIBS) -o $@

# Records of calls: what the renderer writes, and a program that makes them again, without Embree.
$(BUILD)/record/%.o: examples_c/record/%.c $(RECORD_HEADERS) include/volgrad.h | $(BUILD)/record
	$(CC) $(C_FLAGS) -O2 -c $< -o $@

$(REPLAY): $(BUILD)/record/replay.o $(BUILD)/record/replay_file.o $(RECORD_OBJECTS) $(LIBRARY)
	$(CC) $^ -lpthread -ldl -lm $(LDFLAGS) -o $@

$(BUILD) $(BUILD)/render $(BUILD)/record $(BUILD)/tests:
	mkdir -p $@

# ---- tests ----

test: deps
	$(MAKE) test-rust test-c test-record test-cli test-scenes

test-rust:
	cargo test --no-fail-fast --features $(FEATURES)

# The host's own tests, and those of the C interface, under the address and undefined behaviour sanitizers.
SANITIZE := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
HOST_TESTS := $(patsubst tests/host/%.c,$(BUILD)/tests/%,$(wildcard tests/host/*.c))
ABI_TESTS := $(patsubst tests/c/%.c,$(BUILD)/tests/%,$(wildcard tests/c/*.c))
ABI_SCRIPTS := $(wildcard tests/c/*.sh)

$(HOST_TESTS): $(BUILD)/tests/%: tests/host/%.c $(HOST) $(HOST_HEADERS) $(RECORD) $(RECORD_HEADERS) $(LIBRARY) | $(BUILD)/tests
	$(CC) $(C_FLAGS) $(SANITIZE) -Iexamples_c/render $< $(filter-out %/main.c,$(HOST)) $(RECORD) $(LIBRARY) $(C_LIBS) -o $@

$(ABI_TESTS): $(BUILD)/tests/%: tests/c/%.c $(wildcard tests/c/*.h) include/volgrad.h $(LIBRARY) | $(BUILD)/tests
	$(CC) $(C_FLAGS) $(SANITIZE) $< $(LIBRARY) -lpthread -ldl -lm $(LDFLAGS) -o $@

test-c: $(HOST_TESTS) $(ABI_TESTS)
	$(BUILD)/tests/reader_test $(SCENES)
	$(BUILD)/tests/queries_test
	@set -e; for t in $(ABI_TESTS); do echo $$t; $$t; done
	@set -e; for t in $(ABI_SCRIPTS); do echo $$t; CC='$(CC)' LIBRARY=$(LIBRARY) sh $$t; done

# Records are made by the renderer and by a small host, and replayed under the sanitizers.
RECORD_TESTS := $(BUILD)/tests/volgrad-replay $(BUILD)/tests/record_test

$(BUILD)/tests/volgrad-replay: examples_c/record/replay.c examples_c/record/replay_file.c $(RECORD) $(RECORD_HEADERS) $(LIBRARY) | $(BUILD)/tests
	$(CC) $(C_FLAGS) $(SANITIZE) $(filter %.c,$^) $(LIBRARY) -lpthread -ldl -lm $(LDFLAGS) -o $@

$(BUILD)/tests/record_test: tests/record/record_test.c $(RECORD) $(RECORD_HEADERS) $(LIBRARY) | $(BUILD)/tests
	$(CC) $(C_FLAGS) $(SANITIZE) $(filter %.c,$^) $(LIBRARY) -lpthread -ldl -lm $(LDFLAGS) -o $@

test-record: $(RENDER) $(REPLAY) $(RECORD_TESTS)
	sh tests/record/replay_test.sh $(RENDER) $(RECORD_TESTS)

test-cli: $(RENDER) $(VENV)/ready
	sh tests/host/cli_test.sh $(RENDER) $(PY)

test-scenes: $(RENDER) $(VENV)/ready
	$(PY) tests/validate/scenes.py --quick --render $(RENDER) --output $(BUILD)/validate-quick

# ---- the long checks, the demo ----

validate: deps
	$(MAKE) $(RENDER)
	$(PY) tests/validate/scenes.py --render $(RENDER) --output $(BUILD)/validate
	VOLGRAD_LONG=1 cargo test --features $(FEATURES) --test unbiased --test energy --test single_scattering --test host_sampler --test metropolis
	$(PYTHON) tests/mutants.py

demo: deps
	$(MAKE) $(RENDER)
	$(PY) demo/demo.py --render $(RENDER) --output $(BUILD)/demo

bench: $(VENV)/ready
	cargo bench --bench line_integrals --bench paths --bench shifts -- $(BENCH_FLAGS)
	$(PY) benches/table.py $(TARGET) README.md demo/costs.png

$(VENV)/ready: requirements.txt | $(BUILD)
	$(PYTHON) -m venv $(VENV)
	$(PY) -m pip install --quiet --disable-pip-version-check -r requirements.txt
	touch $@

# ---- experiments: the figures in README.md ----

MINUTES ?= 28
PEERS_VENV := $(BUILD)/experiments-venv

peers: deps $(PEERS_VENV)/ready
	$(MAKE) $(RENDER)
	$(PEERS_VENV)/bin/python experiments/peers.py --render $(RENDER) --output $(BUILD)/peers --minutes $(MINUTES)

chains: deps $(PEERS_VENV)/ready
	$(MAKE) $(RENDER)
	$(PEERS_VENV)/bin/python experiments/chains.py --render $(RENDER) --output $(BUILD)/chains

TIME ?= 40
RES ?= 128

figures: deps $(PEERS_VENV)/ready
	$(MAKE) $(RENDER)
	$(PEERS_VENV)/bin/python experiments/measures_test.py
	$(PEERS_VENV)/bin/python experiments/figures.py --render $(RENDER) --output $(BUILD)/figures --minutes $(TIME) --resolution $(RES)

$(PEERS_VENV)/ready: experiments/requirements.txt requirements.txt | $(BUILD)
	$(PYTHON) -m venv $(PEERS_VENV)
	$(PEERS_VENV)/bin/python -m pip install --quiet --disable-pip-version-check -r experiments/requirements.txt
	touch $@

# ---- the rest ----

deps:
	sh packaging/deps.sh
	$(MAKE) $(VENV)/ready

header:
	UPDATE_HEADER=1 cargo test --features $(FEATURES) --test header

clean:
	rm -rf $(BUILD)
	cargo clean
