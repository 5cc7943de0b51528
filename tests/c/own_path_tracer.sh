#!/bin/sh
# examples_c/own_path_tracer.c: shifts of a host's own paths do not change the means of the image's blocks. Its seed is fixed; the number of
# passes depends on the machine, so the limits are wide: with 10 passes, the fewest that count, one of 64 scores (Student's t) is beyond 7 with a
# probability of 0.4 %, with 30 of 1e-5; a weight that is wrong by 0.3 % makes 6 (rms), 20 at most. Usage: [CC=cc] [LIBRARY=build/libvolgrad.a] own_path_tracer.sh
set -eu
cd "$(dirname "$0")/../.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
${CC:-cc} -std=c11 -O2 -Wall -Wextra -Wpedantic -Wno-missing-field-initializers -Werror -Iinclude examples_c/own_path_tracer.c \
    "${LIBRARY:-build/libvolgrad.a}" -lm -lpthread -ldl -lgcc_s -o "$work/own_path_tracer"
"$work/own_path_tracer" 4 3 | tee "$work/said"
awk '/^shifts change/ { found = 1; bad = !($9 < 1.8 && $13 < 7 && $17 >= 10) } END { exit !found || bad }' "$work/said"
