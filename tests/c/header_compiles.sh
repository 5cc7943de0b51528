#!/bin/sh
# include/volgrad.h alone, included twice, compiles without a warning as every C and C++ that its users build with; and the library
# exports exactly the functions that it declares. Usage: [LIBRARY=build/libvolgrad.a] header_compiles.sh
set -eu
. "$(dirname "$0")/../try.sh"
cd "$(dirname "$0")/../.."
library=${LIBRARY:-build/libvolgrad.a}

cat >"$work/use.c" <<'C'
#include "volgrad.h"
#include "volgrad.h"
int use(const volgrad_scene *scene, volgrad_film *film, volgrad_queries *queries);
int use(const volgrad_scene *scene, volgrad_film *film, volgrad_queries *queries)
{
    volgrad_path_sampler_options options;
    if (volgrad_path_sampler_options_default(&options, sizeof options) != VOLGRAD_OK) return 1;
    return volgrad_path_sampler_run(scene, queries, &options, 0, 0, 1, film, 0) != VOLGRAD_OK;
}
C
cp "$work/use.c" "$work/use.cpp"
for compiler in gcc:g++ clang:clang++; do
    cc=${compiler%:*} cxx=${compiler#*:}
    if ! command -v "$cc" >/dev/null || ! command -v "$cxx" >/dev/null; then
        echo "skipped $cc and $cxx: not installed"
        continue
    fi
    for standard in c99 c11 c17; do
        try "$cc" -std=$standard -Wall -Wextra -Wpedantic -Wconversion -Werror -Iinclude -fsyntax-only "$work/use.c"
    done
    for standard in c++11 c++17 c++20; do
        try "$cxx" -std=$standard -Wall -Wextra -Wpedantic -Wconversion -Werror -Iinclude -fsyntax-only "$work/use.cpp"
    done
done

# Declared: a name before a parenthesis in the header without its comments. Defined: global text symbols of that prefix.
gcc -E -P -Iinclude "$work/use.c" | grep -o 'volgrad_[a-z0-9_]*(' | tr -d '(' | sort -u >"$work/declared"
nm --defined-only --extern-only "$library" 2>/dev/null | awk '$2 == "T" && $3 ~ /^volgrad_/ { print $3 }' | sort -u >"$work/defined"
try diff "$work/declared" "$work/defined"
echo "header: $(wc -l <"$work/declared") functions"
finish
