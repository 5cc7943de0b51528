#!/bin/sh
# Mutations of chains are recorded by volgrad-render, made again by volgrad-replay, without Embree, and the same bits come of them; a path of
# another host's by record_test. Files that are no records, or were changed, are refused by name.
# Usage: replay_test.sh RENDER REPLAY RECORD_TEST
set -eu
. "$(dirname "$0")/../try.sh"
render=$1 replay=$2 record_test=$3

# says TEXT STATUS FILE: volgrad-replay ends with the status, having said the text.
says() {
    status=0
    env -i "$replay" "$3" >"$work/said" 2>&1 || status=$?
    [ "$status" -eq "$2" ] && grep -q -- "$1" "$work/said"
}

# record SCENE CHAIN:MUTATION [OPTION ...]
record() {
    scene=$1 which=$2
    shift 2
    "$render" "scenes/$scene.xml" -o "$work/$scene.exr" --integrator mmlt --mutations 1 --chains 4 --burn-in 20 --bootstrap 4000 \
        --quiet --debug-chain "$which" "$@" >"$work/recorded"
}

same_words() {
    grep -v 'ray queries' "$work/recorded" >"$work/words"
    head -n "$(wc -l <"$work/words")" "$work/said" | cmp -s - "$work/words"
}

if ldd "$replay" | grep -qi embree; then failed=$((failed + 1)); echo "failed: volgrad-replay uses Embree"; fi
for mutation in 0 1 2 3; do
    try record caustic "1:$mutation" --guide 0
    try says 'the same bits' 0 "$work/caustic.record"
    try same_words
    try [ "$(grep -c 'not valid' "$work/said")" -eq 0 ]
done
try record smoke 0:5 --guide 1 --shift exchangeable --shift-every 1
try says 'the same bits' 0 "$work/smoke.record"
try grep -q 'phase_apex' "$work/said"
try record room 0:7 --guide 2 --shift thesis --shift-kernel ball --shift-radius 0.05 --shift-every 1
try says 'the same bits' 0 "$work/room.record"
try [ ! -e "$work/room.exr" ]

# Another host's path; and the same with another seed: the first query that differs is named.
try "$record_test" "$work/path.record" "$work/other.record"
try says 'the same bits' 0 "$work/path.record"
try says 'not the same bits' 1 "$work/other.record"
try says "query 0, .*: ray .* from .* was from" 1 "$work/other.record"

# Bad files.
try says 'does not begin with VGRECORD' 2 scenes/smoke.vol
try says 'cannot be opened' 2 "$work/none"
head -c 5000 "$work/caustic.record" >"$work/cut"
try says 'was cut off' 2 "$work/cut"
head -c 20 "$work/caustic.record" >"$work/cut"
try says 'does not begin with VGRECORD' 2 "$work/cut"
for at in 400 2000 5000; do
    cp "$work/caustic.record" "$work/changed"
    printf '\377' | dd of="$work/changed" bs=1 seek=$at conv=notrunc 2>/dev/null
    try says 'was changed after it was recorded\|was cut off' 2 "$work/changed"
done
cp "$work/caustic.record" "$work/changed"
printf '\002' | dd of="$work/changed" bs=1 seek=8 conv=notrunc 2>/dev/null
try says 'is a record of version 2' 2 "$work/changed"
printf '\001\000\000\000\143' | dd of="$work/changed" bs=1 seek=8 conv=notrunc 2>/dev/null
try says "was recorded with volgrad's ABI 99" 2 "$work/changed"

# The option's errors.
try sh -c "! '$render' scenes/smoke.xml -o '$work/x.exr' --debug-chain 0:0 2>'$work/said'"
try grep -q 'means nothing without --integrator mmlt' "$work/said"
for wrong in 1 1: :1 -1:2 1:2x; do
    try sh -c "! '$render' scenes/smoke.xml -o '$work/x.exr' --integrator mmlt --debug-chain $wrong 2>'$work/said'"
    try grep -q 'CHAIN:MUTATION' "$work/said"
done

finish
