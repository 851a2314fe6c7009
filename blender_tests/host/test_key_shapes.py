# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/scene/core/key_shapes.py: what shape keys do, as Blender mixes them and as the solver is told."""

import numpy as np
import pytest

from addon.scene.core.key_shapes import KeyShapes, Slider

COUNT = 300


@pytest.fixture
def shapes():
    """Three sliders: one of Basis, one of the first with a group, one without effect."""
    rng = np.random.default_rng(1)
    rest, first, second = (rng.normal(size=(COUNT, 3)).astype(np.float32) for _ in range(3))
    return KeyShapes(
        sliders=(
            Slider("First", 0.0, 1.0, "Basis"),
            Slider("Second", -1.0, 2.0, "First", "Half"),
            Slider("Copy", 0.0, 1.0, "Basis"),
        ),
        rest=rest,
        points={"Basis": rest, "First": first, "Second": second, "Copy": rest.copy()},
        masks={"Half": np.linspace(0.0, 1.0, COUNT)},
        left_alone=(("Muted", "muted"),),
    )


def test_the_solver_finds_values_from_few_rows(shapes):
    meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")
    shapes = shapes.with_effect()
    anchors = np.array([5, 250, 3, 77])
    rest, moved, places = shapes.fit_input(anchors)
    assert len(rest) <= len(anchors) + 2
    np.testing.assert_array_equal(rest[places], shapes.rest[anchors].astype(np.float64))
    fit = meanvalue.SliderFit(rest, moved, places, lower=shapes.lower, upper=shapes.upper, can_move=False)
    found = fit.solve(shapes.mixed([0.5, -0.25], anchors)).values
    np.testing.assert_allclose(found, [0.5, -0.25], atol=1e-3)
