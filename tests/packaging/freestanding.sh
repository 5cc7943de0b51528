#!/bin/sh
# libvolgrad_core needs no operating system, no standard library and cannot panic; and both archives link beside other Rust libraries.
# Usage: [CC=cc] [BUILD=build] freestanding.sh
set -eu
. "$(dirname "$0")/../try.sh"
cd "$(dirname "$0")/../.."
build=${BUILD:-build}
cc=${CC:-cc} library=$build/libvolgrad.a core=$build/libvolgrad_core.a
hosted="-lm -lpthread -ldl -lgcc_s"

no_lines() { # FILE
    [ ! -s "$1" ] || { cat "$1"; false; }
}

# What it asks of the host; the archive is one object, so that this is all.
nm --undefined-only "$core" | awk 'NF == 2 { print $2 }' | sort -u >"$work/undefined"
grep -vxE 'memcpy|memmove|memset|memcmp' "$work/undefined" >"$work/unknown" || true
try no_lines "$work/unknown"
echo "libvolgrad_core needs $(tr '\n' ' ' <"$work/undefined")"
nm -C "$core" | grep -E 'panicking|_fail$|unwind' >"$work/panics" || true # make panics says where from
try no_lines "$work/panics"
nm --defined-only --extern-only "$library" "$core" | awk 'NF == 3 && $3 !~ /^volgrad_/' >"$work/foreign"
try no_lines "$work/foreign"

# All but EXR is in it.
functions() {
    nm --defined-only --extern-only "$1" | awk '$2 == "T" { print $3 }' | sort
}
functions "$library" | grep -v '^volgrad_exr_' >"$work/without-exr"
functions "$core" >"$work/in-core"
try diff "$work/without-exr" "$work/in-core"

# The same program with and without a system under it.
# shellcheck disable=SC2086 # a list of words
try "$cc" -std=c99 -O1 -Iinclude examples_c/path_gradient.c "$library" $hosted -o "$work/hosted"
if [ "$(uname -m)" = x86_64 ]; then
    try "$cc" -std=c11 -O1 -ffreestanding -fno-stack-protector -nostdlib -static -Iinclude \
        tests/packaging/bare.c examples_c/path_gradient.c "$core" -o "$work/bare"
    nm --undefined-only "$work/bare" >"$work/undefined"
    try no_lines "$work/undefined"
    try "$work/hosted" >"$work/hosted.txt"
    try "$work/bare" >"$work/bare.txt"
    try diff "$work/hosted.txt" "$work/bare.txt"
else
    echo "skipped the program without a system: it is for x86-64"
fi

# Beside another Rust library, in either order, and with all of both.
cat >"$work/two.c" <<'C'
#include <math.h>
#include "volgrad.h"
int other_library(void);
int main(void)
{
    volgrad_phase phase = { VOLGRAD_PHASE_HENYEY_GREENSTEIN, 0 };
    volgrad_phase_value value;
    volgrad_vec3 back = { -1, 0, 0 }, on = { 0, 1, 0 };
    if (volgrad_phase_eval(&phase, back, on, &value) != VOLGRAD_OK || fabs(value.value - 0.0795774715) > 1e-7) return 1;
    return other_library() == 3 ? 0 : 2;
}
C
try rustc --edition 2024 --crate-type staticlib -O tests/packaging/other.rs -o "$work/libother.a"
for archive in "$library" "$core"; do
    for order in "$archive $work/libother.a" "$work/libother.a $archive" \
        "-Wl,--whole-archive $archive -Wl,--no-whole-archive $work/libother.a"; do
        # shellcheck disable=SC2086 # lists of words
        try "$cc" -std=c99 -Iinclude "$work/two.c" $order $hosted -o "$work/two"
        try "$work/two"
    done
done

finish
