"""Types of the methods to compare with."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import Execution

def arap(
    vertices: ArrayLike,
    faces: ArrayLike,
    anchors: ArrayLike,
    targets: ArrayLike,
    roi: ArrayLike | None = None,
    *,
    iterations: int = 100,
    tolerance: float = 1e-06,
    threads: int = 0,
    execution: Execution | None = None,
) -> NDArray[np.float64]: ...
def laplacian(
    vertices: ArrayLike,
    faces: ArrayLike,
    anchors: ArrayLike,
    targets: ArrayLike,
    roi: ArrayLike | None = None,
    *,
    threads: int = 0,
    execution: Execution | None = None,
) -> NDArray[np.float64]: ...
def laplacian_surface_editing(
    vertices: ArrayLike,
    faces: ArrayLike,
    anchors: ArrayLike,
    targets: ArrayLike,
    roi: ArrayLike | None = None,
    *,
    rounds: int = 1,
    threads: int = 0,
    execution: Execution | None = None,
) -> NDArray[np.float64]: ...
def poisson_morph(
    first: ArrayLike,
    second: ArrayLike,
    faces: ArrayLike,
    share: float,
    *,
    execution: Execution | None = None,
) -> NDArray[np.float64]: ...
def pyramid(
    vertices: ArrayLike,
    faces: ArrayLike,
    anchors: ArrayLike,
    targets: ArrayLike,
    roi: ArrayLike | None = None,
    *,
    sweeps: int = 300,
    threads: int = 0,
    execution: Execution | None = None,
) -> NDArray[np.float64]: ...
def rotation_invariant(
    vertices: ArrayLike,
    faces: ArrayLike,
    anchors: ArrayLike,
    targets: ArrayLike,
    roi: ArrayLike | None = None,
    *,
    threads: int = 0,
    execution: Execution | None = None,
) -> NDArray[np.float64]: ...
