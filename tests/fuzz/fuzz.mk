# Fuzzing: tests/fuzz/NAME.c is a libFuzzer target, tests/fuzz/corpus/NAME what it starts with, NAME.dict, if there is one, its words.
# api_*.c call the C interface, with bytes for scenes, paths, options and the host's answers; the others read files.
#
#   make fuzz SECONDS=1800 FUZZ=nvdb     runs one target, or all of them, with clang and a nightly Rust; what is new goes to
#                                        build/fuzz/corpus, findings to build/fuzz
#   make test-fuzz                       replays the corpus with any compiler
#
# A call that returns an error which its documentation does not name aborts (docs/reference.py --statuses).

SECONDS ?= 60
FUZZ ?= $(patsubst tests/fuzz/%.c,%,$(filter-out %/replay.c,$(wildcard tests/fuzz/*.c)))
FUZZ_FLAGS = $(SANITIZE) -Iexamples_c/render -D_POSIX_C_SOURCE=200809L -DFUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
FUZZ_LIMITS := -timeout=60 -rss_limit_mb=4096 -close_fd_mask=2 -print_final_stats=1
# The library under the address sanitizer, with debug assertions, checks of overflow, and what libFuzzer looks at to see where an input leads.
FUZZ_RUSTFLAGS := -Zsanitizer=address -Cdebug-assertions -Cdebuginfo=line-tables-only -Cpasses=sancov-module \
	-Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
	-Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares
FUZZ_TRIPLE = $(shell rustc -vV | sed -n 's/^host: //p')
FUZZ_HEADERS := $(wildcard tests/fuzz/*.h) $(BUILD)/documented.h
FUZZ_HOST := $(patsubst %.c,%.o,$(filter-out main.c,$(notdir $(HOST) $(RECORD))))

vpath %.c examples_c/render examples_c/record

$(BUILD)/fuzz $(BUILD)/fuzz/host $(BUILD)/replay/host:
	mkdir -p $@

$(BUILD)/fuzz/libvolgrad.a: $(wildcard src/*.rs src/*/*.rs src/*/*/*.rs) | $(BUILD)/fuzz
	RUSTFLAGS='$(FUZZ_RUSTFLAGS)' CARGO_PROFILE_RELEASE_LTO=off CARGO_TARGET_DIR=$(TARGET)/fuzz \
		cargo +nightly rustc --release --lib --features $(FEATURES) --crate-type staticlib --target $(FUZZ_TRIPLE)
	cp -p $(TARGET)/fuzz/$(FUZZ_TRIPLE)/release/libvolgrad.a $@

$(BUILD)/fuzz/host/%.o: %.c $(HOST_HEADERS) $(RECORD_HEADERS) | $(BUILD)/fuzz/host
	clang $(C_FLAGS) $(FUZZ_FLAGS) -fsanitize=fuzzer-no-link -c $< -o $@

$(BUILD)/replay/host/%.o: %.c $(HOST_HEADERS) $(RECORD_HEADERS) | $(BUILD)/replay/host
	$(CC) $(C_FLAGS) $(FUZZ_FLAGS) -c $< -o $@

$(BUILD)/fuzz/%: tests/fuzz/%.c $(FUZZ_HEADERS) $(addprefix $(BUILD)/fuzz/host/,$(FUZZ_HOST)) $(BUILD)/fuzz/libvolgrad.a
	clang $(C_FLAGS) $(FUZZ_FLAGS) -include $(BUILD)/documented.h -fsanitize=fuzzer $(filter %.c %.o %.a,$^) $(C_LIBS) -o $@

$(BUILD)/replay/%: tests/fuzz/%.c tests/fuzz/replay.c $(FUZZ_HEADERS) $(addprefix $(BUILD)/replay/host/,$(FUZZ_HOST)) $(LIBRARY)
	$(CC) $(C_FLAGS) $(FUZZ_FLAGS) -include $(BUILD)/documented.h $(filter %.c %.o %.a,$^) $(C_LIBS) -o $@

.PHONY: fuzz test-fuzz
.SECONDARY:

fuzz: $(addprefix $(BUILD)/fuzz/,$(FUZZ))
	@set -e; for f in $(FUZZ); do \
		mkdir -p $(BUILD)/fuzz/corpus/$$f; echo "== $$f, $(SECONDS) s"; \
		case $$f in api_*) own="-max_len=1200 -len_control=0" ;; *) own=-max_len=65536 ;; esac; \
		dict=tests/fuzz/$$f.dict; [ ! -e $$dict ] || own="$$own -dict=$$dict"; \
		$(BUILD)/fuzz/$$f $(FUZZ_LIMITS) $$own -artifact_prefix=$(BUILD)/fuzz/$$f- -max_total_time=$(SECONDS) \
			$(BUILD)/fuzz/corpus/$$f tests/fuzz/corpus/$$f </dev/null >$(BUILD)/fuzz/$$f.log 2>&1 \
			|| { tail -n 60 $(BUILD)/fuzz/$$f.log; exit 1; }; \
		grep 'stat::' $(BUILD)/fuzz/$$f.log; done

# What targets say of bad inputs is shown only if one fails.
test-fuzz: $(addprefix $(BUILD)/replay/,$(FUZZ))
	@set -e; for f in $(FUZZ); do \
		$(BUILD)/replay/$$f tests/fuzz/corpus/$$f 2>$(BUILD)/replay/log || { tail -n 60 $(BUILD)/replay/log; exit 1; }; done
