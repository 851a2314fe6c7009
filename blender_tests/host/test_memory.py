# SPDX-License-Identifier: GPL-3.0-or-later
"""Memory of the native module: flat over many binds, and errors by name where the process may have no more.

MEANVALUE_BINDS=1000 binds more often; docs/reliability.md has what came of it.
"""

import os
import pathlib
import subprocess
import sys

import pytest

pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")
if not sys.platform.startswith("linux"):
    pytest.skip("memory is looked at in Linux alone", allow_module_level=True)

ROOT = pathlib.Path(__file__).resolve().parents[2]
BINDS = int(os.environ.get("MEANVALUE_BINDS", "60"))

pytestmark = pytest.mark.slow

COMMON = """
import gc, resource, sys
sys.path.insert(0, {root!r})
import numpy as np, meanvalue
from blender_tests.support.resident import resident_bytes
from blender_tests.support.stress import held_bar
"""

BINDING = """
points, faces, anchors, _ = held_bar(1500, 0.05)
sizes = []
for number in range(20 + {binds}):
    deformer = meanvalue.Deformer(points, faces, anchors, method=("fast", "paper", "full")[number % 3])
    again = deformer.rebind(anchors[: len(anchors) // 2])
    again.solve(points[anchors[: len(anchors) // 2]] + [0.0, 0.0, 0.01])
    deformer.solve(points[anchors])
    bytes_of_one = deformer.report.bytes
    if number >= 20:
        sizes.append(resident_bytes())
first = sorted(sizes[: len(sizes) // 4])[-1]
last = sorted(sizes[-(len(sizes) // 4) :])[0]
print(first, last, bytes_of_one)
"""

SHORT = """
large, small = held_bar(150_000, 0.05)[:3], held_bar(300, 0.05)[:3]  # heaps of threads, 64 MB each, count as used
meanvalue.Deformer(*small).solve(small[0][small[2]])  # what threads need is there
expected = np.array(meanvalue.Deformer(*small).solve(small[0][small[2]]).vertices)
virtual = 4096 * int(open("/proc/self/statm").read().split()[0])
resource.setrlimit(resource.RLIMIT_AS, (virtual + {room}, resource.RLIM_INFINITY))
try:
    meanvalue.Deformer(*large)
    print("bound")
except (MemoryError, meanvalue.SolverFailure) as error:
    print("refused", type(error).__name__, str(error))
gc.collect()
resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
assert np.array_equal(meanvalue.Deformer(*small).solve(small[0][small[2]]).vertices, expected)
print("went on")
"""


def run(script, **values):
    text = (COMMON + script).format(root=str(ROOT), **values)
    result = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr[-2000:]
    return result.stdout


def test_memory_is_flat_over_many_binds():
    first, last, of_one = map(int, run(BINDING, binds=BINDS).split())
    # Of all that are bound, a fraction of one may be missing: the heap is not given back to the byte.
    assert last - first < max(0.02 * BINDS * of_one, 2 * of_one), (first, last, of_one)


@pytest.mark.parametrize("room", [4 << 20, 30 << 20])
def test_a_bind_without_room_is_refused_and_the_process_goes_on(room):
    said = run(SHORT, room=room).splitlines()
    assert said[-1] == "went on"
    assert said[0].startswith("refused"), said
