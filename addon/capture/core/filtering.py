# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise taken off paths without delaying them."""

import math

import numpy as np

from ...scene.core import checks
from ...scene.core.sample_times import runs


def low_pass(positions, rate_hz, cutoff_hz):
    """(f, m, 3) float64: the paths without what is faster than `cutoff_hz`, where half of the power is left.

    Butterworth's filter of second order, forward and backward, so that nothing is delayed; the cut-off of each pass is
    raised to make that of both the one asked for (Winter, Biomechanics and Motor Control of Human Movement, 2009; in
    the tangent, as Robertson and Dowling 2003). Both ends of a run of good samples go on as their point reflection, for
    the length of the filter's memory. Runs between gaps are filtered each for itself; NaN stays NaN; a single sample
    stays.

    positions  (f, m, 3); rate_hz  frames a second; cutoff_hz  below rate_hz / 2; usual for bodies is 6 to 12 Hz.
    Raises InvalidMotionError for what is out of range.
    """
    positions = checks.motion(positions)
    rate, cutoff = checks.positive(rate_hz, "the frame rate", "Hz"), checks.positive(cutoff_hz, "the cut-off", "Hz")
    if cutoff >= 0.5 * rate:
        raise checks.InvalidMotionError(
            f"The cut-off of {cutoff:g} Hz must be below half the frame rate, {0.5 * rate:g} Hz: "
            "there is no faster motion in the take."
        )
    coefficients = _coefficients(rate, cutoff)
    padding = max(10, math.ceil(rate / cutoff))
    result = positions.copy()
    good = ~np.isnan(positions[..., 0])
    segments = [(marker, b, e) for marker in range(positions.shape[1]) for b, e in runs(good[:, marker]) if e - b > 1]
    # Side by side runs of about the same length: a step of the recursion is then one of numpy's for all of them.
    by_size = {}
    for marker, begin, end in segments:
        by_size.setdefault(int(end - begin).bit_length(), []).append((marker, begin, end))
    for group in by_size.values():
        paths = _filtered([positions[b:e, marker] for marker, b, e in group], coefficients, padding)
        for (marker, begin, end), path in zip(group, paths, strict=True):
            result[begin:end, marker] = path
    return result


def _coefficients(rate, cutoff):
    """(b0, b1, b2, a1, a2) of one pass of y_t = b0 x_t + b1 x_t-1 + b2 x_t-2 - a1 y_t-1 - a2 y_t-2."""
    # Two passes square the amplitude: each must fall to 2^(-1/4) where both are to fall to 2^(-1/2). Very near half
    # the rate there is no room for that, and nothing to tell the difference by.
    corner = math.tan(math.pi * cutoff / rate) / (math.sqrt(2.0) - 1.0) ** 0.25
    scale = 1.0 + math.sqrt(2.0) * corner + corner**2
    gain = corner**2 / scale
    return gain, 2.0 * gain, gain, 2.0 * (corner**2 - 1.0) / scale, (1.0 - math.sqrt(2.0) * corner + corner**2) / scale


def _filtered(paths, coefficients, padding):
    """The filtered paths, each (n, 3) with its own n > 1."""
    padded = [_reflected(path, min(padding, len(path) - 1)) for path in paths]
    lengths = np.array([len(path) for path in padded])
    columns = np.zeros((lengths.max(), len(paths), 3))
    for number, path in enumerate(padded):
        columns[: len(path), number] = path
    for _ in range(2):  # forward, then backward: turned round in between, each at its own end
        columns = _turned_round(_one_pass(columns, coefficients), lengths)
    insides = [(min(padding, len(path) - 1), len(path)) for path in paths]
    return [columns[skip : skip + count, number] for number, (skip, count) in enumerate(insides)]


def _reflected(path, count):
    before = 2.0 * path[0] - path[count:0:-1]
    after = 2.0 * path[-1] - path[-2 : -2 - count : -1]
    return np.concatenate([before, path, after])


def _one_pass(columns, coefficients):
    b0, b1, b2, a1, a2 = coefficients
    start = columns[0].copy()  # as if it had rested there for ever
    columns = columns - start
    result = np.zeros_like(columns)
    before, before_that = np.zeros_like(start), np.zeros_like(start)
    for step in range(len(columns)):
        value = b0 * columns[step] - a1 * before - a2 * before_that
        if step > 0:
            value += b1 * columns[step - 1]
        if step > 1:
            value += b2 * columns[step - 2]
        result[step] = value
        before, before_that = value, before
    return result + start


def _turned_round(columns, lengths):
    rows = lengths - 1 - np.arange(len(columns))[:, None]
    turned = np.take_along_axis(columns, np.maximum(rows, 0)[..., None], axis=0)
    return np.where((rows >= 0)[..., None], turned, 0.0)
