#!/bin/sh
# What docs/ shows compiles: every block fenced by ```c alone, as a file, and is run if it has a main; docs/reference.md is what the header makes.
# Usage: [CC=cc] [PYTHON=python3] [LIBRARY=build/libvolgrad.a] docs_examples.sh
set -eu
. "$(dirname "$0")/../try.sh"
cd "$(dirname "$0")/../.."
library=${LIBRARY:-build/libvolgrad.a}

flags="-std=c99 -Wall -Wextra -Wpedantic -Wno-missing-field-initializers -Werror -Iinclude"
try "${PYTHON:-python3}" docs/reference.py --check
for page in docs/*.md; do
    name=$work/$(basename "$page" .md)
    awk -v name="$name" '/^```c$/ { n++; inside = 1; next } /^```$/ { inside = 0 } inside { print > (name "-" n ".c") }' "$page"
done
for source in "$work"/*.c; do
    if grep -q '^int main(' "$source"; then
        # shellcheck disable=SC2086
        try ${CC:-cc} $flags "$source" "$library" -lm -lpthread -ldl -lgcc_s -o "$work/program"
        try "$work/program"
    else
        # shellcheck disable=SC2086
        try ${CC:-cc} $flags -c "$source" -o "$work/object.o"
    fi
done
finish
