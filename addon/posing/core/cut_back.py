# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a solver's answer is the mesh's own, with all of the answer attached."""

import numpy as np


class Cut(np.ndarray):
    """n x 3 of which the solver gave `solved`, N x 3: a drag has to go on from exactly that (decision 0012)."""

    solved = None  #: of copies and parts

    @classmethod
    def of(cls, positions, solved):
        """`positions`, not to be written to any more."""
        cut = positions.view(cls)
        cut.solved = solved
        cut.flags.writeable = False
        return cut
