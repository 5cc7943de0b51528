#!/bin/sh
# The C program in README.md and the small ones in examples_c/ compile as given and print what they should.
# Usage: [CC=cc] [LIBRARY=build/libvolgrad.a] readme_example.sh
set -eu
. "$(dirname "$0")/../try.sh"
cd "$(dirname "$0")/../.."
library=${LIBRARY:-build/libvolgrad.a}

# build_and_run STANDARD SOURCE EXPECTED-PATTERN
build_and_run() {
    if ${CC:-cc} "-std=$1" -Wall -Wextra -Wpedantic -Wno-missing-field-initializers -Werror -Iinclude "$2" "$library" \
        -lm -lpthread -ldl -lgcc_s -o "$work/program" && "$work/program" >"$work/output" && grep -q "$3" "$work/output"; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "failed: $2 should print a line like: $3"
        cat "$work/output" 2>/dev/null || true
    fi
}

# README.md has exactly one fenced block that begins with ```c: a whole program.
if [ "$(grep -c '^```c$' README.md)" -ne 1 ]; then
    echo "README.md should have exactly one block fenced by \`\`\`c"
    exit 1
fi
sed -n '/^```c$/,/^```$/p' README.md | sed '1d;$d' >"$work/readme.c"
# By hand: 2/d towards the lamp and 1 of its fog along y; along z 1 of the camera's fog and 2/d of that edge.
build_and_run c11 "$work/readme.c" '^gradient of log f: 0 2 -1.66667$'
build_and_run c99 examples_c/path_gradient.c '^( 0.00,  0.00,  0.00)       1.0000           1.0000$'
# The exact optical depth is 3.6053.
build_and_run c99 examples_c/custom_medium.c '^step 0.05:      optical depth 3.601'
# Two samplers that use the callbacks in different ways.
build_and_run c99 examples_c/custom_materials.c '^they agree; 0 bad values$'
finish
