"""Checks that measures.py finds the bias and the variance that images were made with, and no bias where there is none.

They fail if bias_and_variance keeps the images' noise or the reference's in the bias, if it takes the images' mean for one image, and
with a bias other than what is expected; also if z of blocks is not that of noise where there is no bias, or not less by the allowance.
"""
import numpy as np
from measures import (Reference, bias_and_variance, bias_and_variance_errors, block_scores, blur, errors, interval_of_log, share_of_variance,
                      share_of_variance_error, z_of_pairs, z_of_reference)  # fmt: skip

SIZE, SEEDS, NOISE, BIAS, REFERENCE_NOISE = 128, 8, 0.1, 0.05, 0.02
BEYOND_2 = 0.0455  # of a normal distribution
SIGMAS = 5  # what is allowed to be off, in standard errors: wrong once in a million times


def synthetic(bias):
    """Images of independent noise, bias in the left half alone, and a reference with noise of its own."""
    random = np.random.default_rng(1)
    truth = 1 + np.linspace(0, 1, SIZE)[None, :, None] * np.ones((SIZE, 1, 3))
    biased = truth * (1 + bias * (np.arange(SIZE) < SIZE // 2)[None, :, None])
    images = biased + NOISE * truth * random.standard_normal((SEEDS, SIZE, SIZE, 3))
    stderr = REFERENCE_NOISE * truth
    reference = truth + stderr * random.standard_normal(truth.shape)
    return images, Reference(reference, stderr, np.zeros((SIZE, SIZE), bool))


def near(name, value, expected, error):
    print(f"{name:40} {value:10.6f}, expected {expected:10.6f} +- {error:.6f}")
    assert abs(value - expected) < SIGMAS * error, name


def main():
    weights = 1 + 3 * REFERENCE_NOISE**2  # mean of 1/reference^2, to second order
    for bias in (0, BIAS):
        images, reference = synthetic(bias)
        found, deviation = bias_and_variance(images, reference), bias_and_variance_errors(images, reference)
        of_bias, of_noise = weights * bias**2 / 2, weights * NOISE**2
        near(f"squared bias of {bias:.0%} in one half", found[0], of_bias, deviation[0])
        near("variance", found[1], of_noise, deviation[1])
        single = np.array([errors(i, reference)["relative_mse"] for i in images])
        if bias == 0:
            beyond = np.abs(block_scores(images, reference, 0)) > 2
            near("share of blocks beyond 2", beyond.mean(), BEYOND_2, np.sqrt(BEYOND_2 / beyond.size))
        near("squared error of one image", single.mean(), of_bias + of_noise, single.std(ddof=1) / np.sqrt(SEEDS) + deviation[0])
    means, plain = images.mean((1, 2, 3)), synthetic(0)[0].mean((1, 2, 3))
    assert z_of_reference(means, reference, 0) > SIGMAS and z_of_pairs(means, plain) > SIGMAS, "bias is not seen"
    assert abs(z_of_reference(plain, reference, 0)) < 4 and abs(z_of_reference(means, reference, 0.1)) < 1e-6, "bias is seen where none is"

    assert (np.abs(block_scores(images, reference, 0)) > 2).mean() > 0.4, "bias of blocks is not seen"
    assert (np.abs(block_scores(images, reference, 2 * BIAS)) > 2).mean() == 0, "bias of blocks is seen within the allowance"

    a, b = np.random.default_rng(3).standard_normal((2, SEEDS, SIZE, SIZE, 3))
    flat = Reference(np.ones((SIZE, SIZE, 3)), np.zeros((SIZE, SIZE, 3)), None)
    for layer, share in ((a + b, 0.25), (3 * a - b, 0.75)):
        pair = layer, 4 * a, flat
        near("a layer's share of the variance", share_of_variance(*pair), share, share_of_variance_error(*pair))

    noise = np.random.default_rng(2).standard_normal((SIZE, SIZE, 3))
    inside = slice(8, -8)
    kept = blur(noise)[inside, inside].var() / blur(np.ones_like(noise), 2)[inside, inside].mean()
    near("variance after blurring", kept, 1, 0.1)
    value, low, high = interval_of_log(lambda x: x, np.array([1.0, 2.0, 3.0, 2.0]))
    assert low < value == 2 < high
    print("measures.py: ok")


if __name__ == "__main__":
    main()
