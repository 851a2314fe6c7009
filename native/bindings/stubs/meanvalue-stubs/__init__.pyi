"""Types of the compiled module; what each is and does is told by its docstring, help(meanvalue)."""

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

class BindReport:
    @property
    def anchor_count(self) -> int: ...
    @property
    def bytes(self) -> int: ...
    @property
    def carriers(self) -> list[int]: ...
    @property
    def components(self) -> list[Component]: ...
    @property
    def detached_triangle_count(self) -> int: ...
    @property
    def free_count(self) -> int: ...
    @property
    def guarded(self) -> list[int]: ...
    @property
    def guarded_by_reason(self) -> dict[str, list[int]]: ...
    @property
    def guarded_reasons(self) -> dict[str, int]: ...
    @property
    def level_sizes(self) -> list[int]: ...
    @property
    def longest_ring(self) -> int: ...
    @property
    def part_of(self) -> NDArray[np.int32]: ...
    @property
    def row_count(self) -> int: ...
    @property
    def timings(self) -> dict[str, float]: ...
    @property
    def vertex_count(self) -> int: ...

class BoneFit:
    @property
    def errors(self) -> NDArray[np.float32]: ...
    @property
    def heads(self) -> NDArray[np.float64]: ...
    @property
    def parents(self) -> NDArray[np.int32]: ...
    @property
    def tails(self) -> NDArray[np.float64]: ...
    @property
    def transforms(self) -> NDArray[np.float64]: ...
    @property
    def weights(self) -> NDArray[np.float64]: ...

class Cancelled(RuntimeError): ...

class Component:
    @property
    def first_vertex(self) -> int: ...
    @property
    def fixed_count(self) -> int: ...
    @property
    def free_count(self) -> int: ...
    @property
    def soft_count(self) -> int: ...
    @property
    def undetermined(self) -> int: ...
    @property
    def vertex_count(self) -> int: ...

class Deformer:
    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        anchors: ArrayLike,
        *,
        roi: ArrayLike | None = None,
        handles: ArrayLike | None = None,
        rigidity: float | None = None,
        strengths: ArrayLike | None = None,
        border: int = 0,
        loose: Literal['stay', 'follow'] = 'stay',
        method: Literal['fast', 'paper', 'full'] = 'fast',
        threads: int = 0,
        portable: bool = False,
        examples: ArrayLike | None = None,
        stiffness: ArrayLike | None = None,
        early: bool = False,
        execution: Execution | None = None,
    ) -> None: ...
    def drag(self, start: ArrayLike | None = None) -> Drag: ...
    def rebind(
        self,
        anchors: ArrayLike,
        *,
        handles: ArrayLike | None = None,
        rigidity: float | None = None,
        strengths: ArrayLike | None = None,
        border: int = 0,
        stiffness: ArrayLike | None = None,
        early: bool = False,
        execution: Execution | None = None,
    ) -> Deformer: ...
    @property
    def report(self) -> BindReport: ...
    def solve(
        self,
        targets: ArrayLike,
        *,
        start: ArrayLike | None = None,
        tolerance: float | None = None,
        max_iterations: int = 1000,
        settle: bool = False,
        weights: ArrayLike | None = None,
        threads: int = 0,
        execution: Execution | None = None,
    ) -> Solution: ...
    def solve_sequence(
        self,
        targets: ArrayLike,
        *,
        weights: ArrayLike | None = None,
        frames: tuple[int, int] | None = None,
        chunk: int = 48,
        overlap: int = 12,
        kept: list[int] = [],
        tolerance: float | None = None,
        max_iterations: int = 1000,
        on_frame: Callable[[int, NDArray[np.float32]], object] | None = None,
        threads: int = 0,
        execution: Execution | None = None,
    ) -> Sequence: ...
    def start_rebind(
        self,
        anchors: ArrayLike,
        *,
        handles: ArrayLike | None = None,
        rigidity: float | None = None,
        strengths: ArrayLike | None = None,
        border: int = 0,
        stiffness: ArrayLike | None = None,
        early: bool = False,
        execution: Execution | None = None,
    ) -> Task: ...
    def start_solve(
        self,
        targets: ArrayLike,
        *,
        start: ArrayLike | None = None,
        tolerance: float | None = None,
        max_iterations: int = 1000,
        settle: bool = False,
        weights: ArrayLike | None = None,
        threads: int = 0,
        execution: Execution | None = None,
    ) -> Task: ...
    def start_solve_sequence(
        self,
        targets: ArrayLike,
        *,
        weights: ArrayLike | None = None,
        frames: tuple[int, int] | None = None,
        chunk: int = 48,
        overlap: int = 12,
        kept: list[int] = [],
        tolerance: float | None = None,
        max_iterations: int = 1000,
        threads: int = 0,
        execution: Execution | None = None,
    ) -> Task: ...

class Drag:
    def __enter__(self) -> Drag: ...
    def __exit__(self, *args: object) -> None: ...
    def draft(self, targets: ArrayLike) -> NDArray[np.float64] | None: ...
    def solve(
        self,
        targets: ArrayLike,
        *,
        tolerance: float | None = None,
        max_iterations: int = 1000,
        settle: bool = False,
        weights: ArrayLike | None = None,
        threads: int = 0,
        execution: Execution | None = None,
    ) -> Solution: ...
    def start_solve(
        self,
        targets: ArrayLike,
        *,
        tolerance: float | None = None,
        max_iterations: int = 1000,
        settle: bool = False,
        weights: ArrayLike | None = None,
        threads: int = 0,
        execution: Execution | None = None,
    ) -> Task: ...

class Encoding:
    @property
    def cotangents(self) -> NDArray[np.float64]: ...
    def energy(self, vertices: ArrayLike, *, threads: int = 0, execution: Execution | None = None) -> float: ...
    @property
    def guarded(self) -> NDArray[np.int32]: ...
    @property
    def guarded_by(self) -> dict[str, NDArray[np.int32]]: ...
    def predict(
        self,
        vertices: ArrayLike,
        *,
        threads: int = 0,
        execution: Execution | None = None,
    ) -> NDArray[np.float64]: ...
    @property
    def ring(self) -> NDArray[np.int32]: ...
    @property
    def ring_offsets(self) -> NDArray[np.int32]: ...
    @property
    def vertex_count(self) -> int: ...
    @property
    def weights(self) -> NDArray[np.float64]: ...

class Execution:
    def __init__(self) -> None: ...
    def cancel(self) -> None: ...
    @property
    def cancelled(self) -> bool: ...
    @property
    def progress(self) -> float: ...
    @property
    def stage(self) -> str: ...

class Follower:
    def __init__(
        self,
        carrier_vertices: ArrayLike,
        carrier_faces: ArrayLike,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        kind: Literal['auto', 'cloth', 'rigid'] = 'auto',
        threads: int = 0,
        portable: bool = False,
        execution: Execution | None = None,
    ) -> None: ...
    def follow(
        self, carrier_posed: ArrayLike, *, threads: int = 0, execution: Execution | None = None
    ) -> NDArray[np.float64]: ...
    @property
    def kinds(self) -> tuple[str, ...]: ...
    @property
    def parts(self) -> NDArray[np.int32]: ...
    def start_follow(
        self, carrier_posed: ArrayLike, *, threads: int = 0, execution: Execution | None = None
    ) -> Task: ...

class InvalidInput(ValueError): ...

class MorphReport:
    @property
    def bytes(self) -> int: ...
    @property
    def component_count(self) -> int: ...
    @property
    def shape_count(self) -> int: ...
    @property
    def timings(self) -> dict[str, float]: ...
    @property
    def vertex_count(self) -> int: ...

class Morpher:
    def __init__(
        self,
        shapes: ArrayLike,
        faces: ArrayLike,
        anchors: ArrayLike | None = None,
        *,
        threads: int = 0,
        portable: bool = False,
        execution: Execution | None = None,
    ) -> None: ...
    @property
    def report(self) -> MorphReport: ...
    def solve(
        self,
        weights: ArrayLike,
        *,
        parts: ArrayLike | None = None,
        threads: int = 0,
        execution: Execution | None = None,
    ) -> Solution: ...
    def start_solve(
        self,
        weights: ArrayLike,
        *,
        parts: ArrayLike | None = None,
        threads: int = 0,
        execution: Execution | None = None,
    ) -> Task: ...

class Sequence:
    @property
    def converged(self) -> NDArray[np.bool_]: ...
    @property
    def energies(self) -> NDArray[np.float64]: ...
    @property
    def errors(self) -> tuple[tuple[int, str], ...]: ...
    @property
    def first(self) -> int: ...
    @property
    def iterations(self) -> NDArray[np.int32]: ...
    @property
    def snaps(self) -> tuple[int, ...]: ...
    @property
    def vertices(self) -> NDArray[np.float32]: ...

class SliderFit:
    def __init__(
        self,
        rest: ArrayLike,
        shapes: ArrayLike,
        anchors: ArrayLike,
        *,
        lower: ArrayLike = 0.0,
        upper: ArrayLike = 1.0,
        can_move: bool = True,
        threads: int = 0,
    ) -> None: ...
    @property
    def alike(self) -> tuple[tuple[int, int], ...]: ...
    def solve(
        self,
        targets: ArrayLike,
        weights: ArrayLike | None = None,
        *,
        start: ArrayLike | None = None,
        steady: bool = False,
        execution: Execution | None = None,
    ) -> SliderValues: ...
    def solve_sequence(
        self,
        targets: ArrayLike,
        weights: ArrayLike | None = None,
        *,
        execution: Execution | None = None,
    ) -> SliderValues: ...
    def start_solve(
        self,
        targets: ArrayLike,
        weights: ArrayLike | None = None,
        *,
        start: ArrayLike | None = None,
        steady: bool = False,
        execution: Execution | None = None,
    ) -> Task: ...
    def start_solve_sequence(
        self,
        targets: ArrayLike,
        weights: ArrayLike | None = None,
        *,
        execution: Execution | None = None,
    ) -> Task: ...
    @property
    def unseen(self) -> tuple[int, ...]: ...

class SliderValues:
    @property
    def outliers(self) -> NDArray[np.bool_]: ...
    @property
    def residuals(self) -> NDArray[np.float64]: ...
    @property
    def transform(self) -> NDArray[np.float64]: ...
    @property
    def values(self) -> NDArray[np.float64]: ...

class Solution:
    @property
    def all_iterations(self) -> int: ...
    @property
    def converged(self) -> bool: ...
    @property
    def energies(self) -> list[float]: ...
    @property
    def energy(self) -> float: ...
    @property
    def example_weights(self) -> NDArray[np.float64] | None: ...
    @property
    def gradient(self) -> float: ...
    @property
    def initial_energy(self) -> float: ...
    @property
    def initial_gradient(self) -> float: ...
    @property
    def iterations(self) -> int: ...
    @property
    def stop_reason(self) -> str: ...
    @property
    def timings(self) -> dict[str, float]: ...
    @property
    def vertices(self) -> NDArray[np.float64]: ...

class SolverFailure(RuntimeError): ...
class TooLittleMemory(MemoryError): ...

class Surface:
    def __init__(self, vertices: ArrayLike, faces: ArrayLike) -> None: ...
    def nearest(
        self,
        points: ArrayLike,
        normals: ArrayLike | None = None,
        least_cosine: float = 0.0,
        *,
        threads: int = 0,
    ) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]: ...

class SurfaceWays:
    def __init__(
        self, vertices: ArrayLike, edges: ArrayLike, faces: ArrayLike, *, gap: float = 0.0, threads: int = 0
    ) -> None: ...
    def distances(self, seeds: ArrayLike, limit: float) -> NDArray[np.float64]: ...
    def falloff(self, seeds: ArrayLike, limit: float, free: float = 0.0) -> NDArray[np.float64]: ...
    def limb(self, vertex: int, least: float, limit: float) -> float: ...
    @property
    def parts(self) -> NDArray[np.int32]: ...

class Task:
    @property
    def early(self) -> Deformer | None: ...
    @property
    def finished(self) -> bool: ...
    def result(self) -> Any: ...
    def wait(self, seconds: float | None = None) -> bool: ...

def blend(
    encodings: list[Encoding],
    weights: ArrayLike,
    *,
    threads: int = 0,
    execution: Execution | None = None,
) -> Encoding: ...
def border_edges(vertex_count: int, face_corners: ArrayLike, face_starts: ArrayLike) -> NDArray[np.int32]: ...
def build_info() -> dict[str, str | int]: ...
def deform(
    vertices: ArrayLike, faces: ArrayLike, anchors: ArrayLike, targets: ArrayLike, **as_deformer: Any
) -> Solution: ...
def encode(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    threads: int = 0,
    execution: Execution | None = None,
) -> Encoding: ...
def find_snaps(
    shapes: ArrayLike, targets: ArrayLike, size: float, *, weights: ArrayLike | None = None
) -> tuple[int, ...]: ...
def first_of_place(points: ArrayLike, distance: float) -> NDArray[np.int32]: ...
def first_of_seams(
    points: ArrayLike, face_corners: ArrayLike, face_starts: ArrayLike, distance: float
) -> NDArray[np.int32]: ...
def fit_bones(
    rest: ArrayLike,
    frames: ArrayLike,
    *,
    count: int = 20,
    error: float | None = None,
    influences: int = 4,
    joints: bool = True,
    armature: tuple[ArrayLike, ...] | None = None,
    faces: ArrayLike | None = None,
    threads: int = 0,
    execution: Execution | None = None,
) -> BoneFit: ...
def start_bind(
    vertices: ArrayLike,
    faces: ArrayLike,
    anchors: ArrayLike,
    *,
    roi: ArrayLike | None = None,
    handles: ArrayLike | None = None,
    rigidity: float | None = None,
    strengths: ArrayLike | None = None,
    border: int = 0,
    loose: Literal['stay', 'follow'] = 'stay',
    method: Literal['fast', 'paper', 'full'] = 'fast',
    threads: int = 0,
    portable: bool = False,
    examples: ArrayLike | None = None,
    stiffness: ArrayLike | None = None,
    early: bool = False,
    execution: Execution | None = None,
) -> Task: ...
def start_bind_morph(
    shapes: ArrayLike,
    faces: ArrayLike,
    anchors: ArrayLike | None = None,
    *,
    threads: int = 0,
    portable: bool = False,
    execution: Execution | None = None,
) -> Task: ...
def start_fit_bones(
    rest: ArrayLike,
    frames: ArrayLike,
    *,
    count: int = 20,
    error: float | None = None,
    influences: int = 4,
    joints: bool = True,
    armature: tuple[ArrayLike, ...] | None = None,
    faces: ArrayLike | None = None,
    threads: int = 0,
    execution: Execution | None = None,
) -> Task: ...
def start_transfer(
    source_rest: ArrayLike,
    source_shapes: ArrayLike,
    source_faces: ArrayLike,
    target_rest: ArrayLike,
    target_faces: ArrayLike,
    correspondence: tuple[ArrayLike, ArrayLike],
    *,
    close: ArrayLike | None = None,
    threads: int = 0,
    execution: Execution | None = None,
) -> Task: ...
def transfer(
    source_rest: ArrayLike,
    source_shapes: ArrayLike,
    source_faces: ArrayLike,
    target_rest: ArrayLike,
    target_faces: ArrayLike,
    correspondence: tuple[ArrayLike, ArrayLike],
    *,
    close: ArrayLike | None = None,
    threads: int = 0,
    execution: Execution | None = None,
) -> NDArray[np.float64]: ...
def triangulate(vertices: ArrayLike, faces: ArrayLike) -> tuple[NDArray[np.int32], NDArray[np.int32]]: ...
