# SPDX-License-Identifier: GPL-3.0-or-later
"""What the next answer of a drag will be like: shown while the solver is at work on it."""

from collections import deque
from dataclasses import dataclass

import numpy as np

#: A handle that moves rigidly has six degrees of freedom.
MOST_CHANGES = 6

#: A change adds a direction where so much of it is not in later ones.
LEAST_NEW = 0.3

#: Along each direction, no farther than so many times what it was seen to go.
FARTHEST = 3.0

#: Of the mesh's size: how far an anchor may be from where the changes together have it.
MOST_LEFT = 2e-3

#: Of the way between two answers, root mean squares: one that was predicted worse ends predictions until one is better.
MOST_WRONG = 0.5


@dataclass(frozen=True)
class Change:
    """Between two answers."""

    targets: np.ndarray  # 3 k float64
    shape: np.ndarray  # n x 3 float32


class Prediction:
    """By secants, as the solver's own (docs/decisions/0012): targets that move on as they did in the last answers take
    the shape on as they did then. Wrong by the square of the move only.

    shape     the last answer, n x 3 float32, or None
    foreseen  the targets for which the mesh shows what at() gave, or None
    """

    def __init__(self, size):
        self._size = size
        self._changes = deque(maxlen=MOST_CHANGES)  # the latest first
        self._targets = self.shape = self.foreseen = None
        self._is_good = True

    def note(self, targets, shape, weights=None):
        """An answer: k x 3 targets, n x 3 float32. Where some count less (weights, k), it tells nothing of others."""
        if weights is not None:
            self._changes.clear()
            self._targets, self.shape = None, shape
            return
        if self._targets is not None and not np.array_equal(targets, self._targets):
            foreseen = self._foresee(targets) if self._changes else None
            change = Change((targets - self._targets).ravel(), shape - self.shape)
            if foreseen is not None:
                self._is_good = _rms(foreseen - shape) <= MOST_WRONG * _rms(change.shape)
            self._changes.appendleft(change)
        self._targets, self.shape = targets, shape

    def begin(self, targets, shape, weights=None):
        """An answer that does not go on from the last one."""
        self._changes.clear()
        self._targets, self._is_good = None, True
        self.note(targets, shape, weights)

    @property
    def is_ready(self):
        """Whether some moves can be answered."""
        return self._is_good and bool(self._changes)

    def at(self, targets):
        """n x 3 float32 for k x 3 targets, or None where too little is known of such a move."""
        shape = self._foresee(targets) if self.is_ready else None
        if shape is not None:
            self.foreseen = targets
        return shape

    def _foresee(self, targets):
        shares = self._shares((targets - self._targets).ravel())
        if shares is None:
            return None
        shape = self.shape.copy()
        for share, change in zip(shares, self._changes, strict=True):
            if share != 0.0:
                shape += np.float32(share) * change.shape
        return shape

    def _shares(self, move):
        """What each change counts in the sum that is nearest to the move, by Gram and Schmidt; None: none is near."""
        directions, shares = [], np.zeros(len(self._changes))
        for number, change in enumerate(self._changes):
            new, made_of = change.targets, np.eye(len(shares))[number]
            for known, known_made_of in directions:
                share = (known @ new) / (known @ known)
                new, made_of = new - share * known, made_of - share * known_made_of
            if not np.linalg.norm(new) > LEAST_NEW * np.linalg.norm(change.targets):
                continue
            times = (new @ move) / (new @ new)
            if abs(times) < FARTHEST:
                move = move - times * new
                shares += times * made_of
                directions.append((new, made_of))
        return shares if np.abs(move).max(initial=0.0) <= MOST_LEFT * self._size else None


def _rms(differences):
    return float(np.sqrt(np.mean(np.square(differences).sum(axis=1))))
