# SPDX-License-Identifier: GPL-3.0-or-later
"""meanvalue.baselines as Python sees it: one calling form, types, errors. The mathematics is tested in C++."""

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")
pytest.importorskip("meanvalue.baselines", reason="built without methods to compare with")

from blender_tests.support.native_calls import (  # noqa: E402
    ENDS,
    TRIANGLES,
    VERTICES,
    bent_targets,
    cancelled_while_solving,
    tube,
)

METHODS = ["laplacian", "laplacian_surface_editing", "pyramid", "arap", "rotation_invariant"]


def test_it_is_a_module_of_its_own():
    from meanvalue.baselines import arap

    assert arap is meanvalue.baselines.arap and meanvalue.baselines.__name__ == "meanvalue.baselines"


def method(name):
    return getattr(meanvalue.baselines, name)


@pytest.mark.parametrize("name", METHODS)
def test_one_calling_form(name):
    targets = bent_targets()
    deformed = method(name)(VERTICES, TRIANGLES, ENDS, targets)
    assert deformed.shape == VERTICES.shape and deformed.dtype == np.float64 and deformed.flags.c_contiguous
    assert np.array_equal(deformed[ENDS], targets)
    assert np.isfinite(deformed).all()
    keywords = {"roi": np.ones(len(VERTICES), bool), "threads": 1, "execution": meanvalue.Execution()}
    again = method(name)(vertices=VERTICES, faces=TRIANGLES, anchors=ENDS, targets=targets, **keywords)
    assert np.array_equal(again, deformed)


def test_options_change_the_result():
    arguments = (VERTICES, TRIANGLES, ENDS, bent_targets())
    baselines = meanvalue.baselines
    for default, other in [
        (baselines.laplacian_surface_editing(*arguments), baselines.laplacian_surface_editing(*arguments, rounds=5)),
        (baselines.pyramid(*arguments), baselines.pyramid(*arguments, sweeps=5)),
        (baselines.arap(*arguments), baselines.arap(*arguments, iterations=1)),
        (baselines.arap(*arguments), baselines.arap(*arguments, tolerance=0.1)),
    ]:
        assert not np.array_equal(default, other)


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"vertices": VERTICES * np.nan}, r"vertices\[0\] is \(nan"),
        ({"faces": TRIANGLES + 1}, "triangle .* names vertex 180"),
        ({"anchors": np.r_[ENDS[:-1], 999]}, "anchor 23 is vertex 999"),
        ({"targets": VERTICES[:3]}, "targets has 3 rows, but there are 24 anchors"),
        ({"targets": np.full((24, 3), np.inf)}, r"targets\[0\] is \(inf"),
        ({"targets": np.full((24, 3), 1e12)}, r"targets\[0\], of vertex 0, is .* at most 1e\+06"),
        ({"roi": np.ones(5, bool)}, "roi has 5 entries"),
        ({"threads": -1}, "threads is -1"),
    ],
)
def test_bad_input_is_refused_by_name(name, change, text):
    arguments = {"vertices": VERTICES, "faces": TRIANGLES, "anchors": ENDS, "targets": bent_targets()} | change
    with pytest.raises(meanvalue.InvalidInput, match=text):
        method(name)(**arguments)


@pytest.mark.parametrize(
    ("name", "options", "text"),
    [
        ("laplacian_surface_editing", {"rounds": 0}, "rounds is 0"),
        ("pyramid", {"sweeps": -1}, "sweeps is -1"),
        ("arap", {"iterations": -1}, "iterations is -1"),
        ("arap", {"tolerance": 0.0}, "tolerance is 0"),
    ],
)
def test_bad_options_are_refused_by_name(name, options, text):
    with pytest.raises(meanvalue.InvalidInput, match=text):
        method(name)(VERTICES, TRIANGLES, ENDS, bent_targets(), **options)


@pytest.mark.parametrize("name", METHODS)
def test_the_interpreter_runs_meanwhile_and_a_cancel_ends_it(name):
    vertices, triangles = tube(150, 120)
    anchors = np.r_[0:150, len(vertices) - 150 : len(vertices)]
    assert cancelled_while_solving(
        lambda execution: method(name)(vertices, triangles, anchors, 2 * vertices[anchors], execution=execution)
    )
