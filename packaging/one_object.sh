#!/bin/sh
# Makes of a Rust static library one object that exports volgrad_* and nothing else, without what these functions do not need. So it links
# beside other Rust libraries, which bring their own copies of the standard library. Usage: one_object.sh IN.a OUT.a
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

functions=$(nm --defined-only --extern-only "$1" 2>/dev/null | awk '$2 == "T" && $3 ~ /^volgrad_/ { print $3 }')
[ -n "$functions" ]
# shellcheck disable=SC2046,SC2086 # lists of words
${LD:-ld} -r --gc-sections --force-group-allocation $(printf -- '-u %s ' $functions) -o "$work/volgrad.o" "$1"
${OBJCOPY:-objcopy} --wildcard --keep-global-symbol='volgrad_*' --strip-debug \
    --remove-section=.llvmbc --remove-section=.llvmcmd "$work/volgrad.o"
rm -f "$2"
${AR:-ar} rcsD "$2" "$work/volgrad.o"
