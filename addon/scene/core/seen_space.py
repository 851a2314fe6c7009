# SPDX-License-Identifier: GPL-3.0-or-later
"""Two spaces of one mesh: where a shape key has its vertices, and where they are seen behind a rig and other keys."""

import functools
from dataclasses import dataclass

import numpy as np

from . import motion

#: A vertex that the rig moves less than this share of what its key does, in some direction, is not brought anywhere.
FLAT = 1e-3

#: Of the size of the mesh: how near to where they are wanted anchors are brought, and in how many rounds at most, where
#: the rig bends space (lattices).
NEAR = 1e-6
MOST_ROUNDS = 12


@dataclass(frozen=True, eq=False)
class SeenSpace:
    """What a rig does, near the rest shape: a vertex that the key moves by d is seen at seen + jacobians @ d."""

    rest: np.ndarray  # n x 3 float64
    seen: np.ndarray  # n x 3 float64
    jacobians: np.ndarray  # n x 3 x 3 float64
    is_affine: bool  # whether that holds however far the key moves it
    size: float  # of the mesh in the rest shape, its bounding-box diagonal

    @property
    def reach(self):
        """What float32 noise of positions is a share of: the size, or how far from the origin they are."""
        return float(max(self.size, np.abs(self.seen).max(initial=0.0), np.abs(self.rest).max(initial=0.0)))

    @property
    def is_identity(self):
        """Whether every vertex is seen where its key has it, but for noise of float32."""
        unit = np.abs(self.jacobians - np.eye(3)).max(initial=0.0) <= 1e-4
        return unit and bool(np.abs(self.seen - self.rest).max(initial=0.0) <= motion.NOISE * self.reach)

    def transform_of(self, members, frame=None):
        """4 x 4: what the rig does to the vertices `members` as a whole: turn, shear, scale and translation.

        frame: 3 x 3, from a space without the object's uneven scale to the object's own: then it turns and scales
        evenly in that, as a control can.
        """
        linear = self.jacobians[members].mean(axis=0)
        if frame is not None:
            inverse = np.linalg.inv(frame)
            left, stretch, right = np.linalg.svd(inverse @ linear @ frame)
            linear = frame @ (stretch[0] * left @ right) @ inverse  # skinning shrinks where bones meet: not its most
        if np.linalg.det(linear) <= FLAT * np.linalg.norm(linear) ** 2:  # a fold or a squeeze tells of no turn
            linear = motion.fitted(self.rest[members], self.seen[members])[:3, :3]
        return motion.affine(linear, self.seen[members].mean(axis=0) - linear @ self.rest[members].mean(axis=0))

    @functools.cached_property
    def is_flat(self):
        """n bool: vertices that no key can bring to where they are wanted, since the rig squeezes them: the determinant
        over the squared norm is at most half of what the direction keeps that is squeezed most."""
        norms = np.einsum("nij,nij->n", self.jacobians, self.jacobians)
        return np.abs(np.linalg.det(self.jacobians)) <= 0.5 * FLAT * norms

    @functools.cached_property
    def _inverses(self):
        """n x 3 x 3: of the Jacobians, for every step of a drag; anything where they are flat."""
        return np.linalg.inv(np.where(self.is_flat[:, None, None], np.eye(3), self.jacobians))

    def in_key(self, members, wanted, evaluate=None):
        """k x 3: where the key has to have the vertices `members` for them to be seen at `wanted`, k x 3.

        evaluate: takes n x 3 of the key to n x 3 as seen; asked where the space is not affine. Nothing of `members`
        may be flat. The Jacobian at rest begins, and each round mends it by what came of the last (Broyden 1965).
        """
        inverse = self._inverses[members]  # a copy
        result = self.rest[members] + _applied(inverse, wanted - self.seen[members])
        if self.is_affine or evaluate is None:
            return result
        shape = self.rest.copy()
        step = former = None
        near = NEAR * self.reach
        for _ in range(MOST_ROUNDS):
            shape[members] = result
            missing = wanted - evaluate(shape)[members]
            if np.abs(missing).max(initial=0.0) <= near:
                break
            if former is not None:
                change = former - missing  # Broyden's update: each inverse takes what it is seen as to its step
                along = np.einsum("ki,kij->kj", step, inverse)
                share = np.einsum("kj,kj->k", along, change)
                sure = np.abs(share) > 0.1 * np.einsum("ki,ki->k", step, step)
                off = (step - _applied(inverse, change))[sure, :, None]
                inverse[sure] += (off * along[sure, None, :]) / share[sure, None, None]
            step = _applied(inverse, missing)
            result, former = result + step, missing
        return result


def _applied(matrices, vectors):
    return np.einsum("kij,kj->ki", matrices, vectors)
