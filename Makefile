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
# One scene's volume is not in the repository.
TEAPOT := ../shared/scenes/teapot_cloud.nvdb
SCENES := $(filter-out $(if $(wildcard $(TEAPOT)),,scenes/teapot_cloud.xml),$(wildcard scenes/*.xml))

PACKAGES := assimp expat libpng zlib
EMBREE = $(shell $(CC) $(CPPFLAGS) -E -x c -include embree4/rtcore.h /dev/null >/dev/null 2>&1 && echo embree4 || echo embree3)
C_FLAGS = -std=c11 -ffp-contract=off -Wall -Wextra -Wpedantic -Iinclude $(CPPFLAGS) $(shell pkg-config --cflags $(PACKAGES)) $(CFLAGS)
C_LIBS = $(shell pkg-config --libs $(PACKAGES)) -l$(EMBREE) -lpthread -ldl -lm $(LDFLAGS)

HOST := $(wildcard examples_c/render/*.c)
HOST_HEADERS := $(wildcard examples_c/render/*.h) include/volgrad.h
OBJECTS := $(HOST:examples_c/render/%.c=$(BUILD)/render/%.o)

.PHONY: all deps demo test validate bench peers chains figures header clean test-rust test-c test-cli test-scenes test-nvdb FORCE
.DELETE_ON_ERROR:

all: $(LIBRARY) $(RENDER)

# ---- library and renderer ----

# Cargo knows whether there is something to do.
$(TARGET)/release/libvolgrad.a: FORCE
	cargo rustc --release --lib --features $(FEATURES) --crate-type staticlib

$(LIBRARY): $(TARGET)/release/libvolgrad.a | $(BUILD)
	cp -p $< $@

$(BUILD)/render/%.o: examples_c/render/%.c $(HOST_HEADERS) | $(BUILD)/render
	$(CC) $(C_FLAGS) -O2 -c $< -o $@

$(RENDER): $(OBJECTS) $(LIBRARY)
	$(CC) $^ $(C_LIBS) -o $@

$(BUILD) $(BUILD)/render $(BUILD)/tests:
	mkdir -p $@

# ---- tests ----

test: deps
	$(MAKE) test-rust test-c test-cli test-scenes

test-rust:
	cargo test --no-fail-fast --features $(FEATURES)

# The host's own tests, and those of the C interface, under the address and undefined behaviour sanitizers.
SANITIZE := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
HOST_TESTS := $(patsubst tests/host/%.c,$(BUILD)/tests/%,$(wildcard tests/host/*.c))
ABI_TESTS := $(patsubst tests/c/%.c,$(BUILD)/tests/%,$(wildcard tests/c/*.c))
ABI_SCRIPTS := $(wildcard tests/c/*.sh)

$(HOST_TESTS): $(BUILD)/tests/%: tests/host/%.c $(HOST) $(HOST_HEADERS) $(LIBRARY) | $(BUILD)/tests
	$(CC) $(C_FLAGS) $(SANITIZE) -Iexamples_c/render $< $(filter-out %/main.c,$(HOST)) $(LIBRARY) $(C_LIBS) -o $@

$(ABI_TESTS): $(BUILD)/tests/%: tests/c/%.c $(wildcard tests/c/*.h) include/volgrad.h $(LIBRARY) | $(BUILD)/tests
	$(CC) $(C_FLAGS) $(SANITIZE) $< $(LIBRARY) -lpthread -ldl -lm $(LDFLAGS) -o $@

test-c: $(HOST_TESTS) $(ABI_TESTS)
	$(BUILD)/tests/reader_test $(SCENES)
	$(BUILD)/tests/queries_test
	@set -e; for t in $(ABI_TESTS); do echo $$t; $$t; done
	@set -e; for t in $(ABI_SCRIPTS); do echo $$t; CC='$(CC)' LIBRARY=$(LIBRARY) sh $$t; done

test-cli: $(RENDER) $(VENV)/ready
	sh tests/host/cli_test.sh $(RENDER) $(PY)

test-scenes: $(RENDER) $(VENV)/ready
	$(PY) tests/validate/scenes.py --quick --render $(RENDER) --output $(BUILD)/validate-quick

# ---- NanoVDB files: written by its own library, then read, and rendered as sparse and as dense grids ----

NVDB := $(BUILD)/nvdb

$(BUILD)/tests/nvdb_write: tests/host/nvdb_write.cpp | $(BUILD)/tests
	$(CXX) -std=c++17 -O1 -DNANOVDB_USE_ZIP $< -lz -o $@

$(NVDB)/written: $(BUILD)/tests/nvdb_write
	mkdir -p $(NVDB)
	$< $(NVDB)
	touch $@

test-nvdb: $(BUILD)/tests/nvdb_test $(NVDB)/written $(RENDER) $(VENV)/ready
	$(BUILD)/tests/nvdb_test $(NVDB)
	@set -e; for s in nvdb vol; do $(RENDER) $(NVDB)/$$s.xml -o $(NVDB)/$$s.exr --spp 4 --shift exchangeable 2>$(NVDB)/log || { cat $(NVDB)/log; exit 1; }; done
	$(PY) tests/validate/compare.py --identical $(NVDB)/nvdb.exr $(NVDB)/vol.exr
	@[ -e $(TEAPOT) ] || echo "scenes/teapot_cloud.xml is left out: $(TEAPOT) is not there"

test-c: test-nvdb

# ---- fuzzing: tests/fuzz/NAME.c is a libFuzzer target, tests/fuzz/corpus/NAME what it starts with, NAME.dict, if there is one, its words ----
#
#   make fuzz SECONDS=1800 FUZZ=nvdb     runs one target, or all of them, with clang; what is new goes to build/fuzz/corpus, findings to build/fuzz
#   make test-fuzz                       replays the corpus with any compiler

SECONDS ?= 60
FUZZ ?= $(patsubst tests/fuzz/%.c,%,$(filter-out %/replay.c,$(wildcard tests/fuzz/*.c)))
FUZZ_FLAGS := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer -Iexamples_c/render \
	-D_POSIX_C_SOURCE=200809L -DFUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
FUZZ_LIMITS := -timeout=60 -rss_limit_mb=4096 -max_len=65536 -close_fd_mask=2 -print_final_stats=1
# The library with what libFuzzer looks at to see where an input leads, and with checks of overflow.
FUZZ_RUSTFLAGS := -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
	-Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares -Cdebug-assertions -Ccodegen-units=1
FUZZ_TARGET := $(shell rustc -vV 2>/dev/null | sed -n 's/^host: //p')

$(BUILD)/fuzz $(BUILD)/fuzz/host $(BUILD)/replay/host:
	mkdir -p $@

$(BUILD)/fuzz/libvolgrad.a: $(wildcard src/*.rs src/*/*.rs src/*/*/*.rs) | $(BUILD)/fuzz
	RUSTFLAGS='$(FUZZ_RUSTFLAGS)' cargo rustc --release --lib --features $(FEATURES) --crate-type staticlib --target $(FUZZ_TARGET)
	cp -p $(TARGET)/$(FUZZ_TARGET)/release/libvolgrad.a $@

$(BUILD)/fuzz/host/%.o: examples_c/render/%.c $(HOST_HEADERS) | $(BUILD)/fuzz/host
	clang $(C_FLAGS) $(FUZZ_FLAGS) -fsanitize=fuzzer-no-link -c $< -o $@

$(BUILD)/replay/host/%.o: examples_c/render/%.c $(HOST_HEADERS) | $(BUILD)/replay/host
	$(CC) $(C_FLAGS) $(FUZZ_FLAGS) -c $< -o $@

HOST_PARTS := $(patsubst examples_c/render/%.c,%.o,$(filter-out %/main.c,$(HOST)))

$(BUILD)/fuzz/%: tests/fuzz/%.c $(wildcard tests/fuzz/*.h) $(addprefix $(BUILD)/fuzz/host/,$(HOST_PARTS)) $(BUILD)/fuzz/libvolgrad.a
	clang $(C_FLAGS) $(FUZZ_FLAGS) -fsanitize=fuzzer $< $(filter %.o %.a,$^) $(C_LIBS) -o $@

$(BUILD)/replay/%: tests/fuzz/%.c tests/fuzz/replay.c $(wildcard tests/fuzz/*.h) $(addprefix $(BUILD)/replay/host/,$(HOST_PARTS)) $(LIBRARY)
	$(CC) $(C_FLAGS) $(FUZZ_FLAGS) $(filter %.c %.o %.a,$^) $(C_LIBS) -o $@

.PHONY: fuzz test-fuzz
.SECONDARY:

fuzz: $(addprefix $(BUILD)/fuzz/,$(FUZZ))
	@set -e; for f in $(FUZZ); do \
		mkdir -p $(BUILD)/fuzz/corpus/$$f; echo "== $$f, $(SECONDS) s"; \
		dict=tests/fuzz/$$f.dict; [ -e $$dict ] && dict=-dict=$$dict || dict=; \
		$(BUILD)/fuzz/$$f $(FUZZ_LIMITS) $$dict -artifact_prefix=$(BUILD)/fuzz/$$f- -max_total_time=$(SECONDS) $(BUILD)/fuzz/corpus/$$f tests/fuzz/corpus/$$f \
			</dev/null >$(BUILD)/fuzz/$$f.log 2>&1 || { tail -n 60 $(BUILD)/fuzz/$$f.log; exit 1; }; grep 'stat::' $(BUILD)/fuzz/$$f.log; done

# What targets say of bad inputs is shown only if one fails.
test-fuzz: $(addprefix $(BUILD)/replay/,$(FUZZ))
	@set -e; for f in $(FUZZ); do $(BUILD)/replay/$$f tests/fuzz/corpus/$$f 2>$(BUILD)/replay/log || { tail -n 60 $(BUILD)/replay/log; exit 1; }; done

test-c: test-fuzz

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
