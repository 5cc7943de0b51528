# Builds volgrad's C library and the renderer made of it, and runs everything that checks them.
#
#   make deps       installs what is missing (Debian, Ubuntu); names what is needed elsewhere
#   make            build/libvolgrad.a and build/volgrad-render
#   make demo       deps, and one scene with and without shifts in the same time: under three minutes
#   make test       all tests, and a short comparison with the reference images
#   make install    the libraries, headers, volgrad.pc and CMake's files to PREFIX (/usr/local) under DESTDIR; make uninstall
#   make validate   the long comparison, and the long statistical tests
#   make bench      times line integrals, paths and shifts, writes tables in README.md and demo/costs.png; BENCH_FLAGS=--quick for a look
#   make peers      measures whole renders beside Mitsuba 3 for half an hour (MINUTES=28), writes the table in README.md
#   make chains     measures Metropolis chains with and without shifts for a few minutes, writes the table in README.md
#   make figures    the thesis' figures again and beyond, for forty minutes on two cores: build/figures/figures.html and README.md's part;
#                   TIME=minutes, RES=pixels (128 divided or multiplied by a whole number); goes on where it was stopped
#   make references reference images of our own, for hours: scenes/reference, scenes/README.md; goes on where it was stopped
#   make memcheck   the C tests under valgrind; make test-threads: four threads under a thread sanitizer, with a nightly Rust;
#   make fuzz       fuzzers of the C interface and of all readers of files (SECONDS=60 each), with clang and a nightly Rust: tests/fuzz
#   make header     writes include/volgrad.h anew; make abi, also, accepts its binary interface as the one to keep: tests/abi
#
# CARGO_TARGET_DIR and BUILD say where results go, CFLAGS and LDFLAGS are added to ours.

BUILD ?= build
TARGET := $(or $(CARGO_TARGET_DIR),target)
PYTHON ?= python3
VENV := $(BUILD)/venv
PY := $(VENV)/bin/python

FEATURES := ffi,exr
LIBRARY := $(BUILD)/libvolgrad.a
CORE := $(BUILD)/libvolgrad_core.a
VERSION := $(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml)
SONAME := libvolgrad.so.$(shell sed -n 's/^.define VOLGRAD_ABI_VERSION //p' include/volgrad.h)
SHARED := $(BUILD)/libvolgrad.so.$(VERSION)
RENDER := $(BUILD)/volgrad-render
# One scene's volume is not in the repository (scenes/README.md). Where VOLUMES has it, it is copied.
VOLUMES ?= ../shared/scenes
TEAPOT := $(sort $(patsubst $(VOLUMES)/%,scenes/%,$(wildcard scenes/teapot_cloud.nvdb $(VOLUMES)/teapot_cloud.nvdb)))
SCENES := $(filter-out $(if $(TEAPOT),,scenes/teapot_cloud.xml),$(wildcard scenes/*.xml))

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

.PHONY: all libraries deps demo test validate bench peers chains figures references header abi panics clean install uninstall FORCE
.PHONY: test-rust test-c test-record test-packaging test-cli test-scenes test-nvdb
.DELETE_ON_ERROR:

all: $(LIBRARY) $(RENDER) $(REPLAY)

# ---- library and renderer ----

# Cargo knows whether there is something to do.
$(TARGET)/release/libvolgrad.a: FORCE
	cargo rustc --release --lib --features $(FEATURES) --crate-type staticlib

$(LIBRARY): $(TARGET)/release/libvolgrad.a packaging/one_object.sh | $(BUILD)
	sh packaging/one_object.sh $< $@

# For programs without an operating system: no std, no EXR, no unwinding.
$(TARGET)/freestanding/libvolgrad.a: FORCE
	cargo rustc --profile freestanding --lib --features freestanding --crate-type staticlib

$(CORE): $(TARGET)/freestanding/libvolgrad.a packaging/one_object.sh | $(BUILD)
	sh packaging/one_object.sh $< $@

# The archive's object again, so that no symbol but ours is exported; what EXR needs of the system as in packaging/volgrad.pc.in and
# volgradTargets.cmake.
$(SHARED): $(LIBRARY) include/volgrad.h
	$(CC) -shared -Wl,-soname,$(SONAME) -Wl,-z,defs,-z,relro,-z,now -Wl,--whole-archive $< -Wl,--no-whole-archive \
		$(LDFLAGS) -lgcc_s -lpthread -ldl -lm -o $@
	ln -sf $(@F) $(BUILD)/$(SONAME)
	ln -sf $(SONAME) $(BUILD)/libvolgrad.so

libraries: $(LIBRARY) $(CORE) $(SHARED)

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
	$(MAKE) test-rust test-c test-cpp test-record test-packaging test-cli test-scenes

test-rust:
	cargo test --no-fail-fast --features $(FEATURES)

# Where the freestanding archive could panic: nowhere, or tests/packaging/freestanding.sh fails.
panics: $(BUILD)
	CARGO_PROFILE_FREESTANDING_DEBUG=1 CARGO_TARGET_DIR=$(BUILD)/panics \
		cargo rustc --profile freestanding --lib --features freestanding --crate-type staticlib
	$(PYTHON) tests/packaging/panics.py $(BUILD)/panics/freestanding/libvolgrad.a

# The host's own tests, and those of the C interface, under the address and undefined behaviour sanitizers.
SANITIZE := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
HOST_TESTS := $(patsubst tests/host/%.c,$(BUILD)/tests/%,$(wildcard tests/host/*.c))
ABI_TESTS := $(patsubst tests/c/%.c,$(BUILD)/tests/%,$(wildcard tests/c/*.c))
ABI_SCRIPTS := $(wildcard tests/c/*.sh)

$(HOST_TESTS): $(BUILD)/tests/%: tests/host/%.c $(HOST) $(HOST_HEADERS) $(RECORD) $(RECORD_HEADERS) $(LIBRARY) | $(BUILD)/tests
	$(CC) $(C_FLAGS) $(SANITIZE) -Iexamples_c/render $< $(filter-out %/main.c,$(HOST)) $(RECORD) $(LIBRARY) $(C_LIBS) -o $@

# Every call in them is checked for statuses that its documentation does not name.
$(BUILD)/documented.h: docs/reference.py include/volgrad.h | $(BUILD)
	$(PYTHON) $< --statuses >$@

$(ABI_TESTS): $(BUILD)/tests/%: tests/c/%.c $(wildcard tests/c/*.h) include/volgrad.h $(BUILD)/documented.h $(LIBRARY) | $(BUILD)/tests
	$(CC) $(C_FLAGS) $(SANITIZE) -include $(BUILD)/documented.h $< $(LIBRARY) -lpthread -ldl -lm $(LDFLAGS) -o $@

scenes/%.nvdb: $(VOLUMES)/%.nvdb
	cp $< $@

test-c: $(HOST_TESTS) $(ABI_TESTS) $(TEAPOT)
	$(BUILD)/tests/reader_test $(SCENES)
	@[ -n '$(TEAPOT)' ] || echo 'scenes/teapot_cloud.xml is left out: scenes/teapot_cloud.nvdb is not there'
	$(BUILD)/tests/queries_test
	@set -e; for t in $(ABI_TESTS); do echo $$t; $$t; done
	$(MAKE) test-fuzz
	@set -e; for t in $(ABI_SCRIPTS); do echo $$t; CC='$(CC)' LIBRARY=$(LIBRARY) sh $$t; done

# What users get: the binary interface, the archives, an installation, programs built with it.
PACKAGING_SCRIPTS := $(wildcard tests/packaging/*.sh)

test-packaging: libraries
	CC='$(CC)' $(PYTHON) tests/abi/abi.py
	@set -e; for t in $(PACKAGING_SCRIPTS); do echo $$t; MAKE='$(MAKE)' CC='$(CC)' BUILD='$(BUILD)' sh $$t; done

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

# ---- C++: volgrad.hpp ----

CXX_FLAGS = -std=c++11 -Wall -Wextra -Wpedantic -Werror -Iinclude $(CPPFLAGS) $(CXXFLAGS)
CXX_HEADERS := include/volgrad.h include/volgrad.hpp tests/cpp/fog.hpp

$(BUILD)/tests/no_exceptions_test.o: tests/cpp/no_exceptions_test.cpp $(CXX_HEADERS) | $(BUILD)/tests
	$(CXX) $(CXX_FLAGS) $(SANITIZE) -fno-exceptions -fno-rtti -c $< -o $@

$(BUILD)/tests/volgrad_test: tests/cpp/volgrad_test.cpp $(BUILD)/tests/no_exceptions_test.o $(CXX_HEADERS) $(LIBRARY)
	$(CXX) $(CXX_FLAGS) $(SANITIZE) $< $(BUILD)/tests/no_exceptions_test.o $(LIBRARY) -lpthread -ldl -lm $(LDFLAGS) -o $@

$(BUILD)/tests/fog: examples_c/fog.cpp $(CXX_HEADERS) $(LIBRARY) | $(BUILD)/tests
	$(CXX) $(CXX_FLAGS) -O1 $< $(LIBRARY) -lpthread -ldl -lm $(LDFLAGS) -o $@

# The lamp lights the ball: some of the picture is as bright as its characters go.
.PHONY: test-cpp
test-cpp: $(BUILD)/tests/volgrad_test $(BUILD)/tests/fog
	cd $(BUILD)/tests && ./volgrad_test
	$(BUILD)/tests/fog | grep -q '@@@@'
	CXX='$(CXX)' sh tests/cpp/header_compiles.sh

# ---- what only other tools see: valgrind, and the thread sanitizer of a nightly Rust ----

MEMCHECK_TESTS := $(patsubst tests/c/%.c,$(BUILD)/memcheck/%,$(wildcard tests/c/*.c))
TSAN := $(TARGET)/thread-sanitizer
TSAN_TRIPLE = $(shell rustc -vV | sed -n 's/host: //p')

$(BUILD)/memcheck $(BUILD)/tsan:
	mkdir -p $@

$(MEMCHECK_TESTS): $(BUILD)/memcheck/%: tests/c/%.c $(wildcard tests/c/*.h) include/volgrad.h $(LIBRARY) | $(BUILD)/memcheck
	$(CC) $(C_FLAGS) -O1 -g $< $(LIBRARY) -lpthread -ldl -lm $(LDFLAGS) -o $@

# No read of what was never written, no access out of bounds, no leak, in the C tests; some minutes.
.PHONY: memcheck
memcheck: $(MEMCHECK_TESTS)
	@set -e; for t in $(MEMCHECK_TESTS); do \
		echo $$t; valgrind -q --error-exitcode=1 --leak-check=full --suppressions=tests/c/valgrind.supp $$t; done

# Shared const objects from four threads. std is not instrumented: the core does not use it. The runtime is Rust's: clang's may be older.
test-threads: TSAN_RUNTIME = $(shell rustc +nightly --print sysroot)/lib/rustlib/$(TSAN_TRIPLE)/lib/librustc-nightly_rt.tsan.a
.PHONY: test-threads
test-threads: tests/c/threads_test.c | $(BUILD)/tsan
	RUSTFLAGS='-Zsanitizer=thread -Cunsafe-allow-abi-mismatch=sanitizer' CARGO_PROFILE_RELEASE_LTO=off CARGO_TARGET_DIR=$(TSAN) \
		cargo +nightly rustc --release --lib --features $(FEATURES) --crate-type staticlib --target $(TSAN_TRIPLE)
	clang $(C_FLAGS) -O1 -g -fsanitize=thread -c $< -o $(BUILD)/tsan/threads_test.o
	clang $(BUILD)/tsan/threads_test.o $(TSAN)/$(TSAN_TRIPLE)/release/libvolgrad.a \
		-Wl,--whole-archive $(TSAN_RUNTIME) -Wl,--no-whole-archive -lpthread -ldl -lm -lrt -lresolv -o $(BUILD)/tsan/threads_test
	$(BUILD)/tsan/threads_test

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

test-c: test-nvdb

include tests/fuzz/fuzz.mk

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

references: deps $(PEERS_VENV)/ready
	$(MAKE) $(RENDER)
	$(PEERS_VENV)/bin/python experiments/references.py --render $(RENDER) --output $(BUILD)/references

$(PEERS_VENV)/ready: experiments/requirements.txt requirements.txt | $(BUILD)
	$(PYTHON) -m venv $(PEERS_VENV)
	$(PEERS_VENV)/bin/python -m pip install --quiet --disable-pip-version-check -r experiments/requirements.txt
	touch $@

# ---- installation: PREFIX is where it will be used, DESTDIR a root to collect it under ----

PREFIX ?= /usr/local
LIBDIR ?= lib
INSTALLED_LIB := $(DESTDIR)$(PREFIX)/$(LIBDIR)
INSTALLED_HEADERS := $(patsubst include/%,$(DESTDIR)$(PREFIX)/include/%,$(wildcard include/*))
# From LIBDIR to PREFIX.
UP := $(shell echo $(LIBDIR) | sed 's|[^/][^/]*|..|g')
FILL_IN := sed -e 's|@VERSION@|$(VERSION)|g' -e 's|@LIBDIR@|$(LIBDIR)|g' -e 's|@UP@|$(UP)|g'

# As root there may be no cargo: then what is built already is installed.
install: $(if $(shell command -v cargo 2>/dev/null),libraries)
	install -d $(DESTDIR)$(PREFIX)/include $(INSTALLED_LIB)/pkgconfig $(INSTALLED_LIB)/cmake/volgrad
	install -m 644 $(wildcard include/*) $(DESTDIR)$(PREFIX)/include
	install -m 644 $(LIBRARY) $(CORE) $(INSTALLED_LIB)
	install -m 755 $(SHARED) $(INSTALLED_LIB)
	ln -sf $(notdir $(SHARED)) $(INSTALLED_LIB)/$(SONAME)
	ln -sf $(SONAME) $(INSTALLED_LIB)/libvolgrad.so
	$(FILL_IN) packaging/volgrad.pc.in >$(INSTALLED_LIB)/pkgconfig/volgrad.pc
	$(FILL_IN) packaging/volgradConfig.cmake.in >$(INSTALLED_LIB)/cmake/volgrad/volgradConfig.cmake
	$(FILL_IN) packaging/volgradConfigVersion.cmake.in >$(INSTALLED_LIB)/cmake/volgrad/volgradConfigVersion.cmake
	install -m 644 packaging/volgradTargets.cmake $(INSTALLED_LIB)/cmake/volgrad

uninstall:
	rm -f $(INSTALLED_HEADERS) $(addprefix $(INSTALLED_LIB)/,$(notdir $(LIBRARY) $(CORE) $(SHARED)) $(SONAME) libvolgrad.so)
	rm -f $(INSTALLED_LIB)/pkgconfig/volgrad.pc
	rm -rf $(INSTALLED_LIB)/cmake/volgrad

# ---- the rest ----

deps:
	sh packaging/deps.sh
	$(MAKE) $(VENV)/ready

header:
	UPDATE_HEADER=1 cargo test --features $(FEATURES) --test header

abi: header
	CC='$(CC)' $(PYTHON) tests/abi/abi.py --accept

clean:
	rm -rf $(BUILD)
	cargo clean
