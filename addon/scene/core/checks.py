# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of motion capture, checked before anything is made of them."""

import numpy as np

from ...errors import MeanValueError


class InvalidMotionError(MeanValueError):
    """Motion capture data or settings that nothing sensible can be made of; the message says what to change."""


def motion(positions, name="positions"):
    """`positions` as (f, m, 3) float64, a sample NaN in all three where it is in one. The input is not written to.

    Raises InvalidMotionError for other shapes, for infinite values and where there is nothing.
    """
    array = np.asarray(positions)
    if array.ndim != 3 or array.shape[2] != 3:
        raise InvalidMotionError(
            f"{name} must be an array of frames x markers x 3, but its shape is {array.shape}. "
            "One frame alone is positions[None]."
        )
    if not array.shape[0] or not array.shape[1]:
        raise InvalidMotionError(f"{name} is empty: {array.shape[0]} frames of {array.shape[1]} markers.")
    return _without_infinity(array.astype(np.float64), name)


def points(array, name, count=None, missing_allowed=True):
    """`array` as (k, 3) float64, copied; rows NaN in all three where they are in one.

    Raises InvalidMotionError for other shapes, another number of rows than `count`, infinite values, and for NaN unless
    that is allowed.
    """
    array = np.asarray(array)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidMotionError(f"{name} must be an array of points x 3, but its shape is {array.shape}.")
    if count is not None and len(array) != count:
        raise InvalidMotionError(f"{name} has {len(array)} points where there must be {count}, one for each marker.")
    array = _without_infinity(array.astype(np.float64), name)
    missing = np.isnan(array[:, 0])
    if missing.any() and not missing_allowed:
        raise InvalidMotionError(
            f"{name} lacks {missing.sum()} of {len(array)} points (the first is number {np.argmax(missing)}). "
            "Choose another frame, or fill the gaps first."
        )
    return array


def positive(value, name, unit):
    """float(value). Raises InvalidMotionError unless it is finite and above 0."""
    if not np.isfinite(value) or value <= 0.0:
        raise InvalidMotionError(f"{name} is {value} {unit}, but must be above 0.")
    return float(value)


def _without_infinity(array, name):
    if np.isinf(array).any():
        where = tuple(int(i) for i in np.argwhere(np.isinf(array))[0])
        raise InvalidMotionError(f"{name} is infinite at {where}. Missing samples must be NaN.")
    array[np.isnan(array).any(axis=-1)] = np.nan
    return array
