# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise taken off paths without delaying them."""

import numpy as np

from ...errors import InvalidMotionError
from ...scene.core.sample_times import runs


def low_pass(positions, rate_hz, cutoff_hz):
    """(f, m, 3) float64: the paths without what is faster than `cutoff_hz`, where half of the power is left.

    Butterworth's filter of second order, once forward and once backward, so that nothing is delayed (Winter,
    Biomechanics and Motor Control of Human Movement, 2009): its gain is applied to the spectrum of the path. Runs
    between gaps are filtered each for itself; NaN stays NaN; a single sample stays.

    positions  (f, m, 3); rate_hz  frames a second; cutoff_hz  usual for bodies is 6 to 12 Hz.
    Raises InvalidMotionError unless that is below rate_hz / 2.
    """
    if not cutoff_hz < 0.5 * rate_hz:
        raise InvalidMotionError(
            f"The cut-off of {cutoff_hz:g} Hz must be below half the frame rate, {0.5 * rate_hz:g} Hz: there is no "
            "faster motion in the take"
        )
    result = positions.copy()
    good = ~np.isnan(result[..., 0])
    for marker in range(result.shape[1]):
        for begin, end in runs(good[:, marker]):
            result[begin:end, marker] = _filtered(result[begin:end, marker], cutoff_hz / rate_hz)
    return result


def _filtered(path, cutoff):
    """(n, 3): the path, with `cutoff` in cycles a sample. Beyond its ends it goes on as its point reflection: about the
    line between them that is periodic."""
    line = path[0] + np.linspace(0.0, 1.0, len(path))[:, None] * (path[-1] - path[0])
    away = path - line
    periodic = np.concatenate([away, -away[-2:0:-1]])
    # Each of the two passes leaves 2^(-1/4) of the amplitude at the cut-off.
    gain = 1.0 / (1.0 + (np.sqrt(2.0) - 1.0) * (np.fft.rfftfreq(len(periodic)) / cutoff) ** 4)
    spectrum = gain[:, None] * np.fft.rfft(periodic, axis=0)
    return line + np.fft.irfft(spectrum, len(periodic), axis=0)[: len(path)]
