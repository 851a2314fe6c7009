# SPDX-License-Identifier: GPL-3.0-or-later
"""Hours of live posing: the memory of Blender stays what it was.

MEANVALUE_LIVE_UPDATES=10000 moves the control more often; docs/reliability.md has what came of it.
"""

import math
import os

import numpy as np
import pytest
from support import handles
from support.handles import TOP, move, rest, shown
from support.resident import resident_bytes

pytestmark = pytest.mark.slow

UPDATES = int(os.environ.get("MEANVALUE_LIVE_UPDATES", "300"))
WARM_UP = 100
#: What heap and Blender's own records may grow by, whatever the number of updates: a copy of the shape kept for each
#: would be 33 MB in 10,000.
SLACK = 12 << 20


def test_memory_is_flat_over_many_updates():
    if resident_bytes() is None:
        pytest.skip("the memory of a process is only known in Linux")
    obj, control = handles.tube()
    sizes, before, places = [], (0.0, 0.0, 0.0), set()
    for number in range(WARM_UP + UPDATES):
        place = (2.0 * math.sin(0.05 * number), math.cos(0.03 * number) - 1.0, -abs(math.sin(0.02 * number)))
        move(control, tuple(new - old for new, old in zip(place, before, strict=True)))
        before = place
        if number >= WARM_UP and number % 20 == 0:
            sizes.append(resident_bytes())
            expected = rest(obj)[TOP] + np.array(place, np.float32)
            assert np.abs(shown(obj)[TOP] - expected).max() < 1e-3
            places.add(tuple(np.round(shown(obj)[TOP[0]], 3)))
    assert len(places) > 0.8 * len(sizes)  # it was moved
    print(f"{len(sizes)} looks: {max(sizes[:3]):,} bytes at first, {max(sizes):,} at most, {max(sizes[-3:]):,} at last")
    assert max(sizes[-3:]) - max(sizes[:3]) < SLACK, sizes
