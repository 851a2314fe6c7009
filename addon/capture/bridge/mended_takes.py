# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes with their gaps filled and their noise filtered. The last one is remembered: picking points, one after the
other, does not change it."""

import hashlib

from ..core import filtering, gaps

_last = (None, None)


def steps(recording, longest, cutoff_hz):
    """Generator of (stage, share that is done) that returns (path (f, m, 3), how (f, m) as gaps.fill_gaps() tells).

    recording  with positions (f, m, 3) and rate_hz; longest  gaps to be filled, in samples, by splines and by
    neighbours; cutoff_hz  or None. What is returned must not be written to.
    """
    global _last
    yield "filling gaps", 0.0
    content = hashlib.blake2b(recording.positions.tobytes()).digest()
    key = content, recording.positions.shape, recording.rate_hz, longest, cutoff_hz
    if _last[0] == key:
        return _last[1]
    path, how = gaps.fill_gaps(recording.positions, *longest)
    if cutoff_hz is not None:
        yield "smoothing", 0.2
        path = filtering.low_pass(path, recording.rate_hz, cutoff_hz)
    path.flags.writeable = how.flags.writeable = False
    _last = key, (path, how)
    return _last[1]


def forget():
    global _last
    _last = (None, None)
