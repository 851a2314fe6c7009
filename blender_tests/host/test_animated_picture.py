# SPDX-License-Identifier: GPL-3.0-or-later
"""The animated picture of README."""

import pathlib

import numpy as np
import pytest

PICTURE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "pictures" / "octopus_lift.webp"
MOST_BYTES = 1_500_000


def test_it_moves_and_is_small():
    image = pytest.importorskip("PIL.Image", reason="Pillow is missing").open(PICTURE)
    assert PICTURE.stat().st_size < MOST_BYTES
    assert image.n_frames >= 12
    frames = []
    for number in (0, image.n_frames // 2):
        image.seek(number)
        frames.append(np.asarray(image.convert("RGB"), int))
    changed = (np.abs(frames[0] - frames[1]) > 30).any(axis=2)
    assert 0.005 < changed.mean() < 0.3  # the tentacle, and not the rest
