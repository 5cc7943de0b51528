#!/bin/sh
# Installs what building and testing volgrad needs and this system lacks. Only Debian and Ubuntu: elsewhere it says what is missing.
set -eu

have() { command -v "$1" >/dev/null 2>&1; }
have_library() { have pkg-config && pkg-config --exists "$1"; }
have_embree() { [ -e /usr/include/embree4/rtcore.h ] || [ -e /usr/include/embree3/rtcore.h ]; }
have_nanovdb() { echo '#include <nanovdb/PNanoVDB.h>' | cc -x c -fsyntax-only - 2>/dev/null; }
have_venv() { have python3 && python3 -c 'import ensurepip, venv' 2>/dev/null; }

missing=
need() { # PACKAGE TEST...
    package=$1
    shift
    "$@" || missing="$missing $package"
}

need gcc have cc
need g++ have g++
need pkg-config have pkg-config
need cmake have cmake
need abigail-tools have abidiff
need libembree-dev have_embree
need libassimp-dev have_library assimp
need libexpat1-dev have_library expat
need libpng-dev have_library libpng
need zlib1g-dev have_library zlib
need python3-venv have_venv
need libnanovdb-dev have_nanovdb

if ! have cargo; then
    echo "Rust is missing: see https://rustup.rs" >&2
    exit 1
fi
[ -n "$missing" ] || exit 0

if ! have apt-get; then
    echo "Please install (names are Debian's; Embree may be 3 or 4):$missing" >&2
    exit 1
fi
as_root=
if [ "$(id -u)" -ne 0 ]; then
    as_root=sudo
fi
echo "installing:$missing"
$as_root apt-get update -qq
# shellcheck disable=SC2086 # a list of words
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing
