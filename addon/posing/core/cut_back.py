# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a solver's answer is the mesh's own, with the whole answer attached."""

import numpy as np


class Cut(np.ndarray):
    """n x 3 of which the solver gave `whole`, N x 3: a drag has to go on from exactly that (decision 0012)."""

    whole = None  #: of copies and parts

    @classmethod
    def of(cls, positions, whole):
        """`positions`, not to be written to any more."""
        cut = positions.view(cls)
        cut.whole = whole
        cut.flags.writeable = False
        return cut
