# SPDX-License-Identifier: MPL-2.0
"""The methods of Table 1 in one calling form, timed."""

import time
from dataclasses import dataclass

import meanvalue

from native.benchmarks import reporting

LONG_SECONDS, REPEATS = 6.0, 5  # a longer run is not repeated


@dataclass(frozen=True)
class Outcome:
    """What one method made of one case: (n, 3) vertices, energy at diagonal 1, seconds; the rest where it has it."""

    method: str
    vertices: object
    energy: float
    encode_seconds: object
    decode_seconds: float
    iterations: object = ""
    bytes_per_free: object = ""
    longest_ring: object = ""
    stages: dict | None = None


def outcomes(case):
    """Yields the outcome of every method."""
    encoding = meanvalue.encode(case.vertices, case.faces)

    def energy(vertices):
        return encoding.energy(vertices) / case.diagonal**2

    for method in ("paper", "full"):
        yield by_deformer(case, method, energy)
    for method, function, options in baselines():
        yield by_baseline(case, method, function, options, energy)


def baselines():
    """(name, function, options) of the other methods."""
    module = meanvalue.baselines
    return [
        ("pyramid", module.pyramid, {}),
        ("surface editing", module.laplacian_surface_editing, {"rounds": 1}),
        ("surface editing, 5 rounds", module.laplacian_surface_editing, {"rounds": 5}),
        ("laplacian", module.laplacian, {}),
        ("rotation-invariant", module.rotation_invariant, {}),
        ("arap", module.arap, {}),
    ]


def by_deformer(case, method, energy):
    """Bind and solve."""
    encode_seconds, deformer = timed(
        lambda: meanvalue.Deformer(case.vertices, case.faces, case.anchors, roi=case.roi, method=method)
    )
    decode_seconds, solution = timed(lambda: deformer.solve(case.targets))
    report = deformer.report
    return Outcome(
        method, solution.vertices.copy(), energy(solution.vertices), encode_seconds, decode_seconds,
        solution.iterations, report.bytes / max(report.free_count, 1), getattr(report, "longest_ring", ""),
        {"encode": dict(report.timings), "decode": dict(solution.timings)},
    )  # fmt: skip


def by_baseline(case, method, function, options, energy):
    """One call does all; its seconds are counted as decoding."""
    seconds, vertices = timed(
        lambda: function(case.vertices, case.faces, case.anchors, case.targets, roi=case.roi, **options)
    )
    return Outcome(method, vertices, energy(vertices), "", seconds)


def timed(action):
    """The median seconds of some calls of action(), or of one where that takes long, and its result."""
    start = time.perf_counter()
    result = action()
    seconds = time.perf_counter() - start
    return (seconds, result) if seconds > LONG_SECONDS else reporting.median_seconds(action, REPEATS)
