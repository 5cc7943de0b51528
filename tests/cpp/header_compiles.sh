#!/bin/sh
# include/volgrad.hpp compiles without a warning as every C++ that its users build with, and reaches every function of volgrad.h.
# Usage: header_compiles.sh
set -eu
. "$(dirname "$0")/../try.sh"
cd "$(dirname "$0")/../.."

warnings="-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror"
for cxx in g++ clang++; do
    if ! command -v $cxx >/dev/null; then
        echo "skipped $cxx: not installed"
        continue
    fi
    for standard in c++11 c++14 c++17 c++20; do
        try $cxx -std=$standard $warnings -Iinclude -fsyntax-only tests/cpp/volgrad_test.cpp
        try $cxx -std=$standard $warnings -Iinclude -fno-exceptions -fno-rtti -fsyntax-only tests/cpp/no_exceptions_test.cpp
        try $cxx -std=$standard $warnings -Iinclude -DVOLGRAD_NO_EXCEPTIONS -fsyntax-only tests/cpp/no_exceptions_test.cpp
    done
done

# Plain functions that need no C++ form, one a line.
cat >"$work/plain" <<'PLAIN'
PLAIN
${CXX:-c++} -std=c++11 -E -P -Iinclude -x c++ include/volgrad.h | grep -o 'volgrad_[a-z0-9_]*(' | tr -d '(' | sort -u >"$work/declared"
sed 's|/\*.*\*/||' include/volgrad.hpp | grep -o 'volgrad_[a-z0-9_]*[(,)]' | tr -d '(,)' | sort -u - "$work/plain" >"$work/mentioned"
comm -23 "$work/declared" "$work/mentioned" >"$work/missing"
try [ ! -s "$work/missing" ]
sed 's/^/volgrad.hpp lacks /' "$work/missing"
echo "volgrad.hpp: $(wc -l <"$work/declared") functions"
finish
