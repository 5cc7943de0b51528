#!/bin/sh
# What volgrad-render does at the command line: exit statuses, messages, --crop, seeds, threads, Ctrl-C.
# Usage: cli_test.sh VOLGRAD-RENDER PYTHON        Prints `N passed, N failed`.
set -u

render=$1
python=$2
root=$(cd "$(dirname "$0")/../.." && pwd)
scene=$root/scenes/caustic.xml
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
passed=0
failed=0

result() { # STATUS WHAT
    if [ "$1" -eq 0 ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "failed: $2"
        sed 's/^/    /' "$work/messages"
    fi
}

check() { # WHAT COMMAND...
    what=$1
    shift
    "$@" >>"$work/messages" 2>&1
    result $? "$what"
}

expect() { # STATUS TEXT ARGUMENTS...: exit status and a piece of the messages
    status=$1
    text=$2
    shift 2
    "$render" "$@" >"$work/messages" 2>&1
    actual=$?
    echo "exit status $actual, expected $status" >>"$work/messages"
    [ "$actual" -eq "$status" ]
    result $? "volgrad-render $*: status"
    check "volgrad-render $*: says '$text'" grep -qF -e "$text" "$work/messages"
}

same() { "$python" "$root/tests/validate/compare.py" --identical "$1" "$2"; }
different() { ! same "$1" "$2"; }
header() { # FILE EXPRESSION of h, the EXR's header
    "$python" -c "import sys, OpenEXR; h = OpenEXR.File(sys.argv[1], header_only=True).header(); print({k: str(v) for k, v in h.items()}); sys.exit(not ($2))" "$1"
}

# ---- messages and exit statuses ----

expect 0 "Usage: volgrad-render SCENE.xml -o IMAGE.exr" --help
expect 0 "ABI" --version
expect 2 "no scene given" -o "$work/a.exr"
expect 2 "more than one scene given" "$scene" "$scene" -o "$work/a.exr"
expect 2 "no output given" "$scene"
expect 2 "must end in .exr" "$scene" -o "$work/a.png"
expect 2 "unrecognized option" "$scene" -o "$work/a.exr" --no-such-option
expect 2 "--spp 0: expected" "$scene" -o "$work/a.exr" --spp 0
expect 2 "--time soon: expected" "$scene" -o "$work/a.exr" --time soon
expect 2 "--threads -1: expected" "$scene" -o "$work/a.exr" --threads -1
expect 2 "--seed 1x: expected" "$scene" -o "$work/a.exr" --seed 1x
expect 2 "--shift sideways: expected" "$scene" -o "$work/a.exr" --shift sideways
expect 2 "--shift-radius 0: expected" "$scene" -o "$work/a.exr" --shift exact --shift-radius 0
expect 2 "--shift-run 0: expected" "$scene" -o "$work/a.exr" --shift exact --shift-run 0
expect 2 "--shift-exact none: expected" "$scene" -o "$work/a.exr" --shift two_level --shift-exact none
expect 2 "--shift-alpha 1.5: expected" "$scene" -o "$work/a.exr" --shift log_linear --shift-alpha 1.5
expect 2 "--shift-clamp 0: expected" "$scene" -o "$work/a.exr" --shift first_order --shift-clamp 0
expect 2 "--shift-kernel brick: expected" "$scene" -o "$work/a.exr" --shift exact --shift-kernel brick
expect 2 "--shift-clamp goes with" "$scene" -o "$work/a.exr" --shift exact --shift-clamp 2
for option in run exact alpha clamp; do
    expect 2 "--shift-$option means nothing without a --shift" "$scene" -o "$work/a.exr" --shift-$option 1
done
expect 2 "--shift-kernel means nothing without a --shift" "$scene" -o "$work/a.exr" --shift-kernel tile
expect 2 "--shift-count means nothing without a --shift" "$scene" -o "$work/a.exr" --shift-count 4
expect 2 "--integrator pt: expected" "$scene" -o "$work/a.exr" --integrator pt
expect 2 "--heuristic best: expected" "$scene" -o "$work/a.exr" --integrator bdpt --heuristic best
expect 2 "--heuristic means nothing without --integrator bdpt" "$scene" -o "$work/a.exr" --heuristic power
expect 2 "--guide few: expected" "$scene" -o "$work/a.exr" --integrator bdpt --guide few
expect 2 "--guide means nothing without --integrator bdpt or mmlt" "$scene" -o "$work/a.exr" --guide 2
for vertices in 0 65 few; do
    expect 2 "--light-vertices $vertices: expected" "$scene" -o "$work/a.exr" --integrator bdpt --light-vertices $vertices
done
for factor in -1 nan inf x; do
    expect 2 "--roulette $factor: expected" "$scene" -o "$work/a.exr" --integrator bdpt --roulette $factor
done
for integrator in path mmlt; do
    for option in light-vertices roulette; do
        expect 2 "--$option means nothing without --integrator bdpt" "$scene" -o "$work/a.exr" --integrator $integrator --$option 2
    done
done
expect 2 "--light-vertices: at most 3 with --shift" "$scene" -o "$work/a.exr" --integrator bdpt --shift exact --light-vertices 4
expect 2 "--shift-run means nothing with --integrator bdpt" "$scene" -o "$work/a.exr" --integrator bdpt --shift exact --shift-run 1
for mode in thesis thesis_printed; do
    ball="--shift $mode --shift-kernel ball --shift-radius 0.1"
    for integrator in path bdpt; do
        expect 2 "--shift thesis goes with --integrator mmlt alone" "$scene" -o "$work/a.exr" --integrator $integrator $ball
    done
    expect 2 "--shift thesis needs --shift-kernel ball" "$scene" -o "$work/a.exr" --integrator mmlt --shift $mode --shift-radius 0.1
    expect 2 "--shift thesis needs --shift-kernel ball" "$scene" -o "$work/a.exr" --integrator mmlt $ball --shift-radius 4px
done
expect 2 "2 or more edges, but max_depth is 1" "$scene" -o "$work/a.exr" --integrator bdpt --max-depth 1
wrong_chains() { # OPTION VALUE
    expect 2 "--$1 $2: expected" "$scene" -o "$work/a.exr" --integrator mmlt --$1 $2
}
for option in mutations chains bootstrap large-step shift-every; do
    wrong_chains $option 0
    wrong_chains $option x
done
wrong_chains chains 16777217
wrong_chains burn-in -1
wrong_chains large-step 1.5
for lengths in 5-3 1-4 2-65 4 2- -4 2-4-6 2-x; do
    wrong_chains chain-lengths $lengths
done
for option in mutations chains bootstrap burn-in large-step; do
    expect 2 "--$option means nothing without --integrator mmlt" "$scene" -o "$work/a.exr" --$option 1
done
expect 2 "--chain-lengths means nothing without --integrator mmlt" "$scene" -o "$work/a.exr" --chain-lengths 2-4
expect 2 "--shift-every means nothing without a --shift" "$scene" -o "$work/a.exr" --integrator mmlt --shift-every 4
expect 2 "--shift-every means nothing without --integrator mmlt" "$scene" -o "$work/a.exr" --shift exact --shift-every 4
expect 2 "paths of 5 or more edges (--chain-lengths), but max_depth is 4" "$scene" -o "$work/a.exr" --integrator mmlt --chain-lengths 5-9 --max-depth 4
expect 2 "--crop 4,4,4,8: expected" "$scene" -o "$work/a.exr" --crop 4,4,4,8
expect 2 "--crop reaches beyond the image" "$scene" -o "$work/a.exr" --crop 0,0,129,8
expect 2 "cannot open" "$work/none.xml" -o "$work/a.exr"
expect 1 "cannot write" "$scene" -o "$work/none/a.exr"
mkdir "$work/folder.exr"
expect 1 "is a directory" "$scene" -o "$work/folder.exr"
printf '<scene version="3.0.0">\n <nonsense/>\n</scene>\n' >"$work/bad.xml"
expect 2 "bad.xml:2:" "$work/bad.xml" -o "$work/a.exr"
check "nothing is written after an error" test ! -e "$work/a.exr" -a ! -e "$work/a.png"

# ---- images ----

image() { # NAME ARGUMENTS...
    name=$1
    shift
    "$render" "$scene" -o "$work/$name.exr" --quiet "$@" 2>"$work/messages"
}

check "renders" image one --spp 2 --seed 7 --threads 1
check "writes a preview" test -s "$work/one.png"
check "--quiet is quiet" test ! -s "$work/messages"
check "header: samples per pixel" header "$work/one.exr" "h['samplesPerPixel'] == 2"
for mode in none log_linear exact exchangeable first_order half_order linear_depth two_level; do
    check "$mode: one thread" image "$mode-1" --spp 2 --threads 1 --shift $mode
    check "$mode: three threads" image "$mode-3" --spp 2 --threads 3 --shift $mode
    check "$mode: threads do not change a pixel" same "$work/$mode-1.exr" "$work/$mode-3.exr"
done

tile() { # NAME ARGUMENTS...
    image "$@" --spp 2 --shift two_level --shift-kernel tile --shift-count 8
}
check "tiles, runs: one thread" tile tile-1 --threads 1 --shift-run 3 --shift-exact 2
check "tiles, runs: three threads" tile tile-3 --threads 3 --shift-run 3 --shift-exact 2
check "tiles, runs: threads do not change a pixel" same "$work/tile-1.exr" "$work/tile-3.exr"
check "tiles, runs: header" header "$work/tile-1.exr" \
    "(h['shiftKernel'], h['shiftCount'], h['shiftRun'], h['shiftExact'], 'shiftAlpha' in h) == ('tile', 8, 3, 2, False)"
check "tiles: runs of one vertex" tile tile-run --shift-run 1 --shift-exact 2
check "--shift-run makes another image" different "$work/tile-1.exr" "$work/tile-run.exr"
check "tiles: one exact offset" tile tile-exact --shift-run 3 --shift-exact 1
check "--shift-exact makes another image" different "$work/tile-1.exr" "$work/tile-exact.exr"
check "a disk" image disk --spp 2 --shift log_linear --shift-kernel disk
check "--shift-alpha" image alpha --spp 2 --shift log_linear --shift-kernel disk --shift-alpha 0.25
check "--shift-alpha: header" header "$work/alpha.exr" "h['shiftAlpha'] == 0.25 and h['shiftKernel'] == 'disk'"
check "--shift-alpha makes another image" different "$work/alpha.exr" "$work/disk.exr"
check "--shift-clamp" image clamp --spp 2 --shift first_order --shift-kernel disk --shift-clamp 1.5
check "--shift-clamp: header" header "$work/clamp.exr" "h['shiftClamp'] == 1.5"
check "--shift-clamp: none" image unclamped --spp 2 --shift first_order --shift-kernel disk
check "--shift-clamp makes another image" different "$work/clamp.exr" "$work/unclamped.exr"
# ---- the other integrators ----

mean() { # FILE LOW HIGH
    "$python" -c "import sys; sys.path.insert(0, '$root/tests/validate'); from images import read; m = read(sys.argv[1]).mean(); print(m); sys.exit(not float(sys.argv[2]) < m < float(sys.argv[3]))" "$@"
}

bdpt() { image "$@" --integrator bdpt --spp 2; }
check "bdpt: one thread" bdpt bdpt-1 --threads 1
check "bdpt: two threads" bdpt bdpt-2 --threads 2
check "bdpt: threads do not change a pixel" same "$work/bdpt-1.exr" "$work/bdpt-2.exr"
check "bdpt: header" header "$work/bdpt-1.exr" \
    "(h['integrator'], h['heuristic'], h['samplesPerPixel'], 'chains' in h) == ('bdpt', 'balance', 2, False)"
check "bdpt: header: guides" header "$work/bdpt-1.exr" "h['guideSamples'] == 4 * 128 * 128"
check "bdpt: --guide 4" bdpt bdpt-guide --guide 4
check "bdpt: --guide 4 is what is done without" same "$work/bdpt-1.exr" "$work/bdpt-guide.exr"
for passes in 0 1; do
    check "bdpt: --guide $passes" bdpt bdpt-guide --guide $passes
    check "bdpt: --guide $passes: header" header "$work/bdpt-guide.exr" "h['guideSamples'] == $passes * 128 * 128"
    check "bdpt: --guide $passes makes another image" different "$work/bdpt-1.exr" "$work/bdpt-guide.exr"
done
check "bdpt: --guide in a tenth of the time" image bdpt-timed --integrator bdpt --guide 100000 --time 2
check "bdpt: --guide in a tenth of the time: header" header "$work/bdpt-timed.exr" \
    "h['guideSamples'] < 1e6 and h['renderTimeSeconds'] < 6 and h['samplesPerPixel'] >= 1"
lamp='<shape type="rectangle"><transform name="to_world"><scale value="0.01"/></transform><emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>'
{ sed '/<\/scene>/d' "$scene"; for i in 1 2 3 4; do echo "$lamp$lamp$lamp$lamp"; done; echo "</scene>"; } >"$work/lamps.xml"
"$render" "$work/lamps.xml" -o "$work/lamps.exr" --integrator bdpt --spp 1 --crop 0,0,16,16 --quiet 2>"$work/messages"
check "bdpt: 17 lights: no message" test ! -s "$work/messages"
check "bdpt: no guides for 17 lights" header "$work/lamps.exr" "h['guideSamples'] == 0"
check "bdpt: power heuristic" bdpt bdpt-power --heuristic power
check "bdpt: it makes another image" different "$work/bdpt-1.exr" "$work/bdpt-power.exr"
check "bdpt: its depth is that of the path sampler" bdpt bdpt-shallow --max-depth 2
for option in "light-vertices 1" "roulette 0" "roulette 2" "shift exact"; do
    check "bdpt: --$option" bdpt bdpt-other --$option
    check "bdpt: --$option makes another image" different "$work/bdpt-1.exr" "$work/bdpt-other.exr"
done
check "bdpt: roulette of half the brightness that guides know" header "$work/bdpt-1.exr" "0.05 < h['roulette'] < 0.12"
check "bdpt: --roulette 0.5 is what is done without" bdpt bdpt-other --roulette 0.5
check "bdpt: --roulette 0.5: the same" same "$work/bdpt-1.exr" "$work/bdpt-other.exr"
shifted() { # NAME ARGUMENTS...
    bdpt "$@" --shift exchangeable
}
check "bdpt: shifts: one thread" shifted bdpt-shift-1 --threads 1
check "bdpt: shifts: three threads" shifted bdpt-shift-3 --threads 3
check "bdpt: shifts: threads do not change a pixel" same "$work/bdpt-shift-1.exr" "$work/bdpt-shift-3.exr"
check "bdpt: shifts: header" header "$work/bdpt-shift-1.exr" \
    "(h['integrator'], h['shift'], h['shiftKernel'], h['shiftRun']) == ('bdpt', 'exchangeable', 'tile', 1) and 0.6 < h['roulette'] < 1.4"
check "bdpt: shifts: three light vertices" shifted bdpt-shift-3 --light-vertices 3 --guide 0
check "bdpt: shifts: three light vertices are what is done without" shifted bdpt-other --guide 0
check "bdpt: shifts: the same" same "$work/bdpt-shift-3.exr" "$work/bdpt-other.exr"
check "bdpt: shifts: --light-vertices 1" shifted bdpt-other --light-vertices 1
check "bdpt: shifts: --light-vertices 1 makes another image" different "$work/bdpt-shift-1.exr" "$work/bdpt-other.exr"
# The path sampler's image of 64 samples has a mean of 0.385; that of 16 differs by 2 % or so.
check "bdpt: shifts: many samples" image bdpt-shift-many --integrator bdpt --shift exchangeable --spp 16
check "bdpt: shifts: as bright as by the path sampler" mean "$work/bdpt-shift-many.exr" 0.355 0.415

techniques() { # NAME SCENE ARGUMENTS...: the image and, in a folder of its name, those of its techniques
    name=$1
    from=$2
    shift 2
    "$render" "$from" -o "$work/$name.exr" --integrator bdpt --debug-techniques "$work/$name" --quiet "$@"
}
sum() { # IMAGE MORE FOLDER: the weighted techniques in the folder and MORE, what is seen directly, are the IMAGE, up to single precision
    "$python" - "$root/tests/validate" "$@" <<'END'
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from images import read
image, more, parts = read(sys.argv[2]), read(sys.argv[3]), sorted(Path(sys.argv[4]).glob("*_weighted.exr"))
error = abs(sum(map(read, parts)) + more - image).max() / image.max()
print(len(parts), error)
sys.exit(not (len(parts) == 12 and error < 1e-6))
END
}
check "bdpt: techniques" techniques parts "$scene" --spp 2 --max-depth 4 --crop 40,10,72,30
check "bdpt: what is seen directly" image direct --spp 2 --max-depth 1 --crop 40,10,72,30
check "bdpt: techniques sum to the image" sum "$work/parts.exr" "$work/direct.exr" "$work/parts"
check "bdpt: techniques: header" header "$work/parts/s1_t3_weighted.exr" \
    "(h['lightVertices'], h['cameraVertices'], h['weighted'], h['samplesPerPixel']) == (1, 3, 1, 2)"
check "bdpt: techniques do not change the image" bdpt parts-none --max-depth 4 --crop 40,10,72,30
check "bdpt: techniques do not change the image: the same" same "$work/parts.exr" "$work/parts-none.exr"
cat >"$work/lamp.xml" <<'END'
<scene version="3.0.0">
    <integrator type="volpath"><integer name="max_depth" value="2"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="40"/>
        <transform name="to_world"><lookat origin="0, 1, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/><rfilter type="box"/></film>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="-90"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.5, 0.5"/></bsdf>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="90"/><translate y="2"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0, 0, 0"/></bsdf>
        <emitter type="area"><rgb name="radiance" value="5, 5, 5"/></emitter>
    </shape>
</scene>
END
alike() { # FOLDER: what makes paths of two edges shows as many of them
    "$python" - "$root/tests/validate" "$1" <<'END'
import sys
sys.path.insert(0, sys.argv[1])
from images import read
means = [read(f"{sys.argv[2]}/s{s}_t{3 - s}.exr").mean() for s in range(3)]
print(means)
sys.exit(not (0.05 < min(means) and max(means) < 1.03 * min(means)))  # noise: 0.6 %
END
}
check "bdpt: a floor below a lamp" techniques lamp "$work/lamp.xml" --spp 200
check "bdpt: techniques without weights see the same light" alike "$work/lamp"
expect 2 "--debug-techniques means nothing without --integrator bdpt" "$scene" -o "$work/a.exr" --debug-techniques "$work/none"
expect 1 "cannot make folder" "$scene" -o "$work/a.exr" --integrator bdpt --debug-techniques "$work/none/none"

mmlt() { # NAME ARGUMENTS...
    name=$1
    shift
    image "$name" --integrator mmlt --mutations 3 --burn-in 20 --bootstrap 9000 "$@"
}
check "mmlt: one thread" mmlt mmlt-1 --threads 1 --chains 50
check "mmlt: two threads" mmlt mmlt-2 --threads 2 --chains 50
check "mmlt: threads do not change a pixel" same "$work/mmlt-1.exr" "$work/mmlt-2.exr"
check "mmlt: header" header "$work/mmlt-1.exr" \
    "(h['integrator'], h['samplesPerPixel'], h['burnIn'], h['chainLengthsFirst'], h['chainLengthsLast']) == ('mmlt', 1, 20, 2, 32)"
check "mmlt: header: chains" header "$work/mmlt-1.exr" \
    "50 <= h['chains'] < 50 + 31 and 3 <= h['mutationsPerPixel'] < 3.1 and abs(h['chains'] * h['mutationsPerChain'] / 128 ** 2 - h['mutationsPerPixel']) < 1e-5"
check "mmlt: header: brightness" header "$work/mmlt-1.exr" \
    "0.1 < h['brightness'] < 1 and 0 < h['brightnessRelativeError'] < 1 and h['bootstrapSamples'] == 9000"
for option in "chains 49" "bootstrap 9001" "large-step 0.5" "burn-in 21" "chain-lengths 2-16" "guide 0" "spp 2" "seed 1" "shift exact"; do
    check "mmlt: --$option" mmlt mmlt-other --chains 50 --$option
    check "mmlt: --$option makes another image" different "$work/mmlt-1.exr" "$work/mmlt-other.exr"
done
check "mmlt: shifts, one thread" mmlt mmlt-shift-1 --threads 1 --shift exchangeable --shift-every 2
check "mmlt: shifts, two threads" mmlt mmlt-shift-2 --threads 2 --shift exchangeable --shift-every 2
check "mmlt: shifts: threads do not change a pixel" same "$work/mmlt-shift-1.exr" "$work/mmlt-shift-2.exr"
thesis() { # NAME MODE ARGUMENTS...
    name=$1
    mode=$2
    shift 2
    mmlt "$name" --chains 50 --shift "$mode" --shift-kernel ball --shift-radius 0.2 --shift-alpha 0.25 "$@"
}
check "mmlt: the thesis, one thread" thesis thesis-1 thesis --threads 1
check "mmlt: the thesis, two threads" thesis thesis-2 thesis --threads 2
check "mmlt: the thesis: threads do not change a pixel" same "$work/thesis-1.exr" "$work/thesis-2.exr"
check "mmlt: the thesis: header" header "$work/thesis-1.exr" "(h['shift'], h['shiftKernel'], h['shiftAlpha']) == ('thesis', 'ball', 0.25)"
check "mmlt: the thesis as printed" thesis thesis-printed thesis_printed
check "mmlt: the thesis as printed makes another image" different "$work/thesis-1.exr" "$work/thesis-printed.exr"
check "mmlt: the thesis makes another image than no shifts" different "$work/thesis-1.exr" "$work/mmlt-1.exr"
check "mmlt: --max-depth" mmlt mmlt-shallow --max-depth 6
check "mmlt: --max-depth: header" header "$work/mmlt-shallow.exr" "h['chainLengthsLast'] == 6"
check "mmlt: a crop" mmlt mmlt-crop --crop 16,32,48,40
check "mmlt: --time" image mmlt-timed --integrator mmlt --time 1
check "mmlt: --time: header" header "$work/mmlt-timed.exr" "0.9 < h['renderTimeSeconds'] < 3 and h['mutationsPerChain'] > 10"
"$render" "$scene" -o "$work/noted.exr" --integrator mmlt --mutations 1 --stats >"$work/stats" 2>"$work/messages"
check "mmlt: tells the brightness" grep -q "^brightness 0.[0-9]*, known to [0-9.]* %, from [0-9]* samples" "$work/messages"
check "mmlt: plain progress" grep -qx "100%" "$work/messages"
check "mmlt: stats" grep -q "^mutations  *[1-9]" "$work/stats"
check "mmlt: stats of the bootstrap" grep -qE "^rays +[1-9][0-9]* +[1-9][0-9]* +[1-9][0-9]*$" "$work/stats"
check "mmlt: stats by length sum up" awk '
    /^(large|small) steps/ { all += $3 }
    /^[1-9][0-9]* .*%/ { lengths += 1; sum += $4 }
    END { exit !(lengths > 3 && sum > 0 && sum == all) }' "$work/stats"
check "mmlt: stats of guides" grep -q "^guide samples  *65536 in [0-9.]* s" "$work/stats"
# Interrupted or not, rounds or none: the same image.
check "mmlt: many rounds" image rounds --integrator mmlt --mutations 40 --chains 8 --bootstrap 9000
"$render" "$scene" -o "$work/one-round.exr" --integrator mmlt --mutations 40 --chains 8 --bootstrap 9000 --threads 7 --quiet
check "mmlt: as many rounds as the threads make" same "$work/rounds.exr" "$work/one-round.exr"

check "another seed" image other --spp 2 --seed 8
check "another seed makes another image" different "$work/one.exr" "$work/other.exr"
check "--crop" image crop --spp 1 --crop 16,32,48,40
check "--crop: the file's windows" header "$work/crop.exr" \
    "[list(map(int, c)) for w in (h['dataWindow'], h['displayWindow']) for c in w] == [[16, 32], [47, 39], [0, 0], [127, 127]]"
check "--time stops" image timed --time 0.5
check "--max-depth" image shallow --spp 1 --max-depth 1

# ---- ways to render ----

expect 2 "--integrator auto chooses shifts itself" "$scene" -o "$work/a.exr" --integrator auto --shift exact
expect 2 "--guide means nothing without" "$scene" -o "$work/a.exr" --guide 1
few="--max-depth 6 --crop 32,32,96,96 --seed 5"
expect 0 "--integrator bdpt" "$scene" -o "$work/auto.exr" $few --spp 32
check "auto: on one thread" image auto-1 $few --spp 32 --threads 1
check "auto: the same on any number of threads" same "$work/auto.exr" "$work/auto-1.exr"
check "auto: the chosen way" image auto-bdpt $few --spp 32 --integrator bdpt
check "auto: the image is that of the chosen way" same "$work/auto.exr" "$work/auto-bdpt.exr"
check "auto: the file names it" header "$work/auto.exr" "h['integrator'] == 'bdpt' and h['heuristic'] == 'balance'"
expect 0 "--integrator path" "$root/scenes/smoke.xml" -o "$work/auto-smoke.exr" --spp 32
check "auto: --stats names the way" sh -c "'$render' '$scene' -o '$work/auto-stats.exr' --quiet --stats $few --spp 32 | grep -q 'trial rays.*bdpt'"
check "auto: few samples are traced as paths" image auto-few $few --spp 2
check "auto: few samples as paths" image path-few $few --spp 2 --integrator path
check "auto: few samples are paths" same "$work/auto-few.exr" "$work/path-few.exr"

# ---- layers ----

expect 2 "--first-vertex glass: expected medium, surface, specular or none" "$scene" -o "$work/a.exr" --first-vertex glass
expect 2 "--first-vertex means nothing without --integrator path" "$scene" -o "$work/a.exr" --first-vertex medium --integrator bdpt
for layer in medium surface specular none; do
    expect 0 "" "$scene" -o "$work/layer-$layer.exr" --quiet $few --spp 2 --first-vertex $layer
done
expect 0 "" "$scene" -o "$work/layers.exr" --quiet $few --spp 2 --integrator path
check "layers: they add up to the image" "$python" -c "import sys, numpy, OpenEXR
images = [OpenEXR.File(f).channels()['RGB'].pixels.astype(float) for f in sys.argv[1:]]
sys.exit(not numpy.allclose(sum(images[1:]), images[0], rtol=1e-5, atol=1e-9) or not all(i.any() for i in images[1:4]))" \
    "$work/layers.exr" "$work/layer-medium.exr" "$work/layer-surface.exr" "$work/layer-specular.exr" "$work/layer-none.exr"
check "layers: the file names it" header "$work/layer-medium.exr" "h['firstVertex'] == 'medium'"

# ---- Ctrl-C ----

interrupt() { # NAME ARGUMENTS...: Ctrl-C after a while; leaves the exit status in $status
    name=$1
    shift
    "$render" "$scene" -o "$work/$name.exr" --time 120 --seed 3 "$@" 2>"$work/messages" &
    pid=$!
    sleep 2
    kill -INT "$pid"
    wait "$pid"
    status=$?
}

number() { # FILE NAME: of an attribute
    "$python" -c "import sys, OpenEXR; print('%.0f' % OpenEXR.File(sys.argv[1], header_only=True).header()[sys.argv[2]][0])" "$1" "$2"
}

interrupt stopped --integrator path
check "Ctrl-C: exit status 130, not $status" test "$status" -eq 130
check "Ctrl-C: says so" grep -q "ending this pass" "$work/messages"
check "Ctrl-C: whole passes" header "$work/stopped.exr" "h['samplesPerPixel'] >= 1 and h['samplesPerPixel'] % 1 == 0"
passes=$(number "$work/stopped.exr" samplesPerPixel)
check "Ctrl-C: the same passes without" image whole --seed 3 --integrator path --spp "$passes"
check "Ctrl-C: the image is that of those passes" same "$work/stopped.exr" "$work/whole.exr"
# In passes, in learning guides, in the bootstrap, in rounds.
for arguments in "bdpt" "bdpt --guide 100000" "mmlt" "mmlt --bootstrap 9000"; do
    interrupt stopped-other --integrator $arguments
    check "$arguments: Ctrl-C: exit status 130, not $status" test "$status" -eq 130
    check "$arguments: Ctrl-C: as bright as the whole image" mean "$work/stopped-other.exr" 0.3 0.5
    check "$arguments: Ctrl-C: a preview" test -s "$work/stopped-other.png"
    rm -f "$work"/stopped-other.*
done

check "no unfinished file is left" test -z "$(find "$work" -name '*.part')"

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
