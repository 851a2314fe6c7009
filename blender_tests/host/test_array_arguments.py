# SPDX-License-Identifier: GPL-3.0-or-later
"""What every array argument of the native module takes, and what it refuses by its name: nothing is cast silently."""

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support.native_calls import ENDS, TRIANGLES, VERTICES, bent_targets  # noqa: E402

COUNT = len(ENDS)
BOUND = {
    "vertices": VERTICES, "faces": TRIANGLES, "anchors": ENDS, "roi": np.ones(len(VERTICES), bool),
    "handles": np.repeat([0, 1], COUNT // 2), "strengths": np.ones(COUNT), "stiffness": np.ones(len(VERTICES)),
}  # fmt: skip
SOLVED = {"targets": bent_targets(), "start": VERTICES}


def deformer():
    return meanvalue.Deformer(VERTICES, TRIANGLES, ENDS)


# name: (call, its array arguments)
CALLS = {
    "encode": (meanvalue.encode, {name: BOUND[name] for name in ("vertices", "faces")}),
    "predict": (lambda **arrays: meanvalue.encode(VERTICES, TRIANGLES).predict(**arrays), {"vertices": VERTICES}),
    "energy": (lambda **arrays: meanvalue.encode(VERTICES, TRIANGLES).energy(**arrays), {"vertices": VERTICES}),
    "Deformer": (meanvalue.Deformer, BOUND),
    "deform": (meanvalue.deform, BOUND | {"targets": bent_targets()}),
    "start_bind": (lambda **arrays: meanvalue.start_bind(**arrays).result(), BOUND),
    "solve": (lambda **arrays: deformer().solve(**arrays), SOLVED),
    "start_solve": (lambda **arrays: deformer().start_solve(**arrays).result(), SOLVED),
    "morph": (
        lambda **arrays: meanvalue.Morpher([VERTICES, 1.5 * VERTICES], TRIANGLES).solve([0.5, 0.5], **arrays),
        {"parts": np.array([1])},
    ),
}
FORM = {
    "vertices": "float", "targets": "float", "start": "float", "strengths": "float", "stiffness": "float",
    "faces": "whole numbers", "anchors": "whole numbers", "handles": "whole numbers", "parts": "whole numbers",
    "roi": "bool",
}  # fmt: skip
ARGUMENTS = [(call, argument) for call, (_, arrays) in CALLS.items() for argument in arrays]


def called(call, argument, values):
    function, arrays = CALLS[call]
    return function(**(arrays | {argument: values}))


def of_kind(argument, kinds):
    return FORM[argument] in kinds


@pytest.mark.parametrize(("call", "argument"), ARGUMENTS)
def test_what_numpy_would_cast_silently_is_refused_by_name_and_type(call, argument):
    right = np.asarray(CALLS[call][1][argument])
    wrong = {
        "complex128": right + 0.5j if right.dtype != bool else right.astype(complex),
        "<U32": right.astype(float).astype("U32"),
        "|S32": right.astype(float).astype("S32"),
        "object": right.astype(object),
        "datetime64": right.astype("int64").astype("datetime64[s]"),
    }
    if not of_kind(argument, ["float"]):
        wrong["float64"] = right.astype(float)
    wrong["int32" if of_kind(argument, ["bool"]) else "bool"] = right.astype(
        "int32" if of_kind(argument, ["bool"]) else bool
    )
    for type_name, values in wrong.items():
        with pytest.raises(meanvalue.InvalidInput, match=rf"^{argument} has the .*{FORM[argument]}") as refusal:
            called(call, argument, values)
        assert type_name.strip("<|") in str(refusal.value)
        assert ("flatnonzero" in str(refusal.value)) == (type_name == "bool" and argument == "anchors")


@pytest.mark.parametrize(("call", "argument"), ARGUMENTS)
def test_what_makes_no_array_or_one_of_another_shape_is_refused_by_name(call, argument):
    right = CALLS[call][1][argument]
    for values in (object(), {"a": 1}, 3, [[1, 2], [3]], "word", right[..., None]):
        with pytest.raises(meanvalue.InvalidInput, match=f"^{argument} ") as refusal:
            called(call, argument, values)
    assert ("ravel" in str(refusal.value)) == (argument in ("anchors", "handles", "parts")), "the last, a column"


@pytest.mark.parametrize(("call", "argument"), ARGUMENTS)
def test_masked_values_are_not_taken_for_values(call, argument):
    right = CALLS[call][1][argument]
    masked = np.ma.masked_array(right, np.zeros(np.shape(right), bool))
    with pytest.raises(meanvalue.InvalidInput, match=f"^{argument} is a masked array"):
        called(call, argument, masked)


@pytest.mark.parametrize(("call", "argument"), [pair for pair in ARGUMENTS if of_kind(pair[1], ["whole numbers"])])
@pytest.mark.parametrize("number", [2**64 - 1, 2**63, 2**31, -(2**31) - 1, -(2**63)])
def test_a_number_out_of_range_is_told_as_it_was_given(call, argument, number):
    values = np.asarray(CALLS[call][1][argument]).astype(np.uint64 if number > 0 else np.int64)
    values.flat[-1] = number
    of = {"handles": "handle", "parts": "shape"}.get(argument, "vertex")
    with pytest.raises(meanvalue.InvalidInput, match=f"{argument} holds {number}, which no number of a {of} can be"):
        called(call, argument, values)


@pytest.mark.parametrize(("call", "argument"), ARGUMENTS)
def test_lists_and_other_number_types_mean_the_same(call, argument):
    right = np.asarray(CALLS[call][1][argument])
    others = [right.tolist(), np.asfortranarray(right), np.repeat(right, 2, axis=0)[::2]]
    if argument == "faces":
        others.append((np.arange(0, right.size + 1, 3), right.ravel()))  # as polygons
    if of_kind(argument, ["whole numbers"]):
        others += [right.astype(kind) for kind in ("uint8", "uint64", "int64", ">i4")]
    if of_kind(argument, ["float"]):
        others += [right.astype(kind) for kind in (">f8", "longdouble")]

    def numbers(result):
        if isinstance(result, meanvalue.Deformer):
            result = result.solve(bent_targets())
        if isinstance(result, meanvalue.Encoding):
            return result.weights
        return result.vertices if isinstance(result, meanvalue.Solution) else np.asarray(result)

    expected = numbers(called(call, argument, right))
    for values in others:
        assert np.array_equal(numbers(called(call, argument, values)), expected)
    if of_kind(argument, ["float"]):
        single = right.astype(np.float32)
        expected = numbers(called(call, argument, single.astype(np.float64)))
        assert np.array_equal(numbers(called(call, argument, single)), expected)


def test_an_empty_list_is_no_anchors():
    assert meanvalue.Deformer(VERTICES, TRIANGLES, []).report.anchor_count == 0
