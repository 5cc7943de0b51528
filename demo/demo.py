"""Renders one scene without and with shared paths in the same time, and shows what that changes.

Writes plain.png, shifted.png (as seen) and side_by_side.png (reference, plain, shifted), and prints the errors.
"""
import argparse
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "validate"))

from images import attribute, exposure_of, read, relative_mse, tonemap, upscale, write_png, write_side_by_side  # noqa: E402

SCENE = "room"
SECONDS = 5
TURNS = 8  # of each, one after the other, so that a busy machine slows both alike
PLAIN = ["--integrator", "path"]
SHIFT = [*PLAIN, "--shift", "exchangeable", "--shift-count", "15", "--shift-run", "1"]

SCALE = 3  # of the pictures
BLURRED = 4  # noise that neighbouring pixels share does not go away in blocks of so many pixels


def render(renderer, name, options, seed, output):
    """The image, its samples per pixel, and its seconds on the clock and of all processors."""
    file = output / f"{name}-{seed}.exr"
    command = [renderer, ROOT / "scenes" / f"{SCENE}.xml", "-o", file, "--time", str(SECONDS), "--seed", str(seed), "--quiet", *options]
    subprocess.run(command, check=True)
    return read(file), *(attribute(file, a) for a in ("samplesPerPixel", "renderTimeSeconds", "cpuTimeSeconds"))


def average(turns):
    """All turns' images together, with the sums of the rest."""
    images, samples, seconds, processor = zip(*turns)
    return sum(i * n for i, n in zip(images, samples)) / sum(samples), sum(samples), sum(seconds), sum(processor)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--render", default="build/volgrad-render")
    parser.add_argument("--output", default="build/demo")
    arguments = parser.parse_args()
    output = Path(arguments.output)
    output.mkdir(parents=True, exist_ok=True)
    reference, stderr = (read(ROOT / "scenes" / "reference" / f"{SCENE}{kind}.exr") for kind in ("", "_stderr"))

    print(f"{SCENE}, {SECONDS * TURNS} s each, on all cores, in turns; errors are relative, without the reference's noise\n", flush=True)
    kinds = {"plain": PLAIN, "shifted": SHIFT}
    turns = {name: [] for name in kinds}
    for seed in range(TURNS):
        for name, options in kinds.items():
            turns[name].append(render(arguments.render, name, options, seed, output))

    print(f"{'':10}{'seconds':>9}{'of all cores':>14}{'samples/pixel':>15}{'error':>9}{f'of {BLURRED}x{BLURRED} blocks':>16}")
    images, errors = {}, {}
    for name in kinds:
        images[name], samples, seconds, processor = average(turns[name])
        errors[name] = [relative_mse(images[name], reference, stderr, size) for size in (1, BLURRED)]
        pixel, block = (f"{max(0, e) ** 0.5:.2%}" for e in errors[name])
        print(f"{name:10}{seconds:9.1f}{processor:14.1f}{samples:15.0f}{pixel:>9}{block:>16}")
    pixel, block = (p / s for p, s in zip(errors["plain"], errors["shifted"]))
    print(f"\nratio of squared errors, plain to shifted: {pixel:.2f}, of blocks {block:.2f}")

    exposure = exposure_of(reference)
    shown = {n: upscale(tonemap(i, exposure), SCALE) for n, i in {"reference": reference, **images}.items()}
    for name in images:
        write_png(output / f"{name}.png", shown[name])
    write_side_by_side(output / "side_by_side.png", list(shown.items()))
    print(*(f"{output / name}.png" for name in ("plain", "shifted", "side_by_side")), sep="\n")


if __name__ == "__main__":
    main()
