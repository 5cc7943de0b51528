"""Error of one image against a reference.

    compare.py IMAGE.exr REFERENCE.exr [STDERR.exr]   relative errors, with the reference's noise taken out if its errors are given
    compare.py --identical A.exr B.exr                fails unless all pixels are the same, bit for bit
"""
import argparse
import sys

import numpy as np

from images import read, relative_mse, squared_error

TRIMMED = 0.001  # share of the pixels, the worst, left out of the trimmed error: fireflies make up much of the plain one


def root(mse):
    return np.sqrt(max(0.0, mse))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--identical", action="store_true")
    arguments = parser.parse_args()
    images = [read(f) for f in arguments.files]
    if any(i.shape != images[0].shape for i in images):
        sys.exit("the images differ in size")
    if arguments.identical:
        different = (images[0] != images[1]).any(2).sum()
        sys.exit(f"{different} pixels differ" if different else 0)

    image, reference = images[:2]
    stderr = images[2] if len(images) > 2 else None
    error, _ = squared_error(image, reference, stderr)
    by_pixel = np.sort(error.mean(2).ravel())
    trimmed = by_pixel[: int((1 - TRIMMED) * by_pixel.size)].mean()
    print(f"relRMSE                    {root(error.mean()):.4f}")
    print(f"  without worst {TRIMMED:.1%} pixels {root(trimmed):.4f}")
    if stderr is not None:
        print(f"  without reference's noise {root(relative_mse(image, reference, stderr)):.4f}")
        print(f"  of 4x4 blocks, likewise   {root(relative_mse(image, reference, stderr, 4)):.4f}")
    print("ratio of means R, G, B     ", *(f"{r:.4f}" for r in image.mean((0, 1)) / reference.mean((0, 1))))


if __name__ == "__main__":
    main()
