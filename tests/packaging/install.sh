#!/bin/sh
# A fresh installation, and the programs of examples_c/consumers built with it, in C and in C++, as their users would.
# Usage: [MAKE=make] [CC=cc] [CXX=c++] [BUILD=build] install.sh
set -eu
. "$(dirname "$0")/../try.sh"
cd "$(dirname "$0")/../.."
make=${MAKE:-make} build=${BUILD:-build} prefix=/opt/volgrad
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml)
soname=libvolgrad.so.$(sed -n 's/^#define VOLGRAD_ABI_VERSION //p' include/volgrad.h)
stage=$work/stage
lib=$stage$prefix/lib
# This may run inside make.
unset MAKEFLAGS MFLAGS MAKELEVEL

quietly() {
    "$@" >"$work/log" 2>&1 || { cat "$work/log"; false; }
}

prints() { # EXPECTED PROGRAM
    [ "$("$2")" = "$1" ] || { "$2"; false; }
}

# e^-2
in_c="volgrad $version in C: 0.1353 of the light passes"
in_cpp="volgrad $version in C++: 0.1353 of the light passes"

try quietly "$make" install BUILD="$build" DESTDIR="$stage" PREFIX="$prefix"

# The shared library: its name, and that it exports what the header declares and nothing else.
try [ "$(readlink "$lib/libvolgrad.so")" = "$soname" ]
try [ "$(readlink "$lib/$soname")" = "libvolgrad.so.$version" ]
try grep -q "SONAME.*\[$soname\]" <<END
$(readelf -d "$lib/libvolgrad.so")
END
echo '#include <volgrad.h>' | "${CC:-cc}" -E -P -I"$stage$prefix/include" - >"$work/header"
grep -o 'volgrad_[a-z0-9_]*(' "$work/header" | tr -d '(' | sort -u >"$work/declared"
nm -D --defined-only "$lib/libvolgrad.so" | awk '{ print $3 }' | sort >"$work/exported"
try diff "$work/declared" "$work/exported"

# pkg-config and make.
export PKG_CONFIG_PATH="$lib/pkgconfig"
try [ "$(pkg-config --modversion volgrad)" = "$version" ]
cp -r examples_c/consumers "$work/consumers"
try quietly "$make" -C "$work/consumers/pkg_config"
export LD_LIBRARY_PATH="$lib"
try prints "$in_c" "$work/consumers/pkg_config/fog_c"
try prints "$in_cpp" "$work/consumers/pkg_config/fog_cpp"
LD_LIBRARY_PATH= try prints "$in_c" "$work/consumers/pkg_config/fog_c_static"
unset LD_LIBRARY_PATH

# CMake, with what is installed. It finds this version and none that is incompatible.
try quietly cmake -S "$work/consumers/find_package" -B "$work/found" -DCMAKE_PREFIX_PATH="$stage$prefix"
try quietly cmake --build "$work/found"
for kind in '' _static; do
    try prints "$in_c" "$work/found/fog_c$kind"
    try prints "$in_cpp" "$work/found/fog_cpp$kind"
done
try prints "$in_c" "$work/found/fog_c_core"
for version in 0.0 0.2 0.1.9 1.0; do
    sed "s/find_package(volgrad 0.1 /find_package(volgrad $version /" examples_c/consumers/find_package/CMakeLists.txt \
        >"$work/consumers/find_package/CMakeLists.txt"
    try eval "! quietly cmake -S '$work/consumers/find_package' -B '$work/other' -DCMAKE_PREFIX_PATH='$stage$prefix' >/dev/null"
done

# CMake, with the sources. Cargo has compiled them before; it need not be in the PATH.
in_system() { # PROGRAM ARGUMENTS
    PATH=$(getconf PATH) quietly "$@"
}
cmake=$(command -v cmake) cargo=$(command -v cargo)
try in_system "$cmake" -S examples_c/consumers/add_subdirectory -B "$work/added" -Dvolgrad_CARGO="$cargo"
try in_system "$cmake" --build "$work/added"
try prints "$in_c" "$work/added/fog_c"
try prints "$in_cpp" "$work/added/fog_cpp"
try prints "$in_cpp" "$work/added/fog_cpp_shared"

try quietly "$make" uninstall BUILD="$build" DESTDIR="$stage" PREFIX="$prefix"
find "$stage" ! -type d >"$work/left"
try [ ! -s "$work/left" ]

finish
