# SPDX-License-Identifier: GPL-3.0-or-later
"""The compiled deformers of this session, and the calls into them. They are a cache of what the scene already says:
nothing is lost when one is dropped, and nothing here holds a Blender object."""

import collections
import re
from dataclasses import dataclass

import numpy as np

from ..errors import CancelledError, SceneError, SolverError
from . import native_loader
from .core import result

# What is said of input that the native module refuses.
REFUSED_MESH = "The solver cannot use this mesh: {}. Correct the mesh there and press Update"
REFUSED_EXAMPLE = "The mesh cannot be posed like this: {}. Mute that key, or choose Nothing in Advanced > Pose Like"
REFUSED_POSE = "The solver cannot reach this pose: {}"

#: So many vertices that may move take half a second to bind, so that it is worth it to pose them meanwhile.
EARLY_VERTICES = 50_000

CACHE_ENTRIES = 4
CACHE_BYTES = 2 << 30


class DeformerCache:
    """Keeps at most `capacity` entries and, but for the newest, at most `byte_limit` bytes."""

    def __init__(self, capacity, byte_limit):
        self._capacity = capacity
        self._byte_limit = byte_limit
        self._entries = {}  # key: (entry, bytes, family), the newest last

    def get(self, key):
        """The entry, now the newest, or None."""
        found = self._entries.pop(key, None)
        if found is None:
            return None
        self._entries[key] = found
        return found[0]

    def relative(self, family):
        """The newest entry that was put with this family, or None. It stays as old as it is."""
        found = (entry for entry, _, its_family in reversed(self._entries.values()) if its_family == family)
        return next(found, None)

    def put(self, key, entry, byte_count, family=None):
        """family: what entries have in common that may be made from each other."""
        self._entries.pop(key, None)
        self._entries[key] = (entry, byte_count, family)
        total = sum(byte_count for _, byte_count, _ in self._entries.values())
        while len(self._entries) > 1 and (len(self._entries) > self._capacity or total > self._byte_limit):
            total -= self._entries.pop(next(iter(self._entries)))[1]

    def clear(self):
        self._entries.clear()


#: Bindings by their fingerprints, and what rooms bind besides handles by their own.
cache = DeformerCache(CACHE_ENTRIES, CACHE_BYTES)


#: A native deformer, and a tuple of sentences on what is unusual about what it is of.
Binding = collections.namedtuple("Binding", "deformer notes")


def remember(bind_input, binding):
    found = bind_input.fingerprint
    cache.put(found, binding, int(binding.deformer.report.bytes), found.family)


def bind_steps(bind_input, triangles, execution, portable=False, known=None, early=False):
    """Steps (see solver/job.py) to a new Binding; `triangles` m x 3 int32.

    portable: with the same bits on every processor of an architecture, and slower.
    known: a Binding of the same mesh, region and method to other anchors, as cache.relative() of the family of the
    fingerprint gives it: the same one in two thirds of the time, and `triangles` are not looked at.
    early: if the mesh is large, the Job has an `early` meanwhile.

    @throws NativeModuleError, SceneError, SolverError, CancelledError.
    """
    mesh = bind_input.solver_mesh
    anchors, held = _held(mesh, bind_input)
    held["early"] = early and np.count_nonzero(mesh.roi) >= EARLY_VERTICES
    examples = []  # shapes, and the names of their keys
    if bind_input.examples is not None and known is None:
        names = bind_input.examples.names
        examples = [(shape, names[number]) for shape, number in mesh.examples(bind_input.examples.shapes())]
    try:
        if known is not None:
            deformer = yield from steps(known.deformer.start_rebind, anchors, execution=execution, **held)
        else:
            deformer = yield from steps(
                native_loader.module().start_bind,
                mesh.rest,
                mesh.triangles(triangles),
                anchors,
                roi=None if mesh.roi.all() else mesh.roi,
                method=bind_input.method,
                loose=bind_input.loose,
                portable=portable,
                examples=[shape for shape, _ in examples] or None,
                execution=execution,
                **held,
            )
    except SolverError as error:
        reason = str(error.__cause__)
        if "examples[" not in reason:
            raise
        named = re.sub(r"examples\[(\d+)\]", lambda found: f"shape key '{examples[int(found[1])][1]}'", reason)
        raise SolverError(REFUSED_EXAMPLE.format(named)) from error
    if result.nothing_is_held(deformer.report):
        remedy = bind_input.notes or ["Pin three of its vertices, or choose a region that leaves some out"]
        raise SceneError(". ".join(["No part that may move has three fixed points that are not in one line", *remedy]))
    return Binding(deformer, tuple(result.unheld_notes(deformer.report, mesh.places)))


@dataclass(eq=False)
class Drag:
    """A row of solves, each from the answer of the one before: a native Drag, what it is of, and what is shown of it.

    binding  None while the mesh is being bound: there are drafts by a Job's `early` then, and no native Drag
    answer   n x 3 float32: the last; where it began before that
    drafted  the bridge.targets.Targets of which a draft is shown, or None
    snaps    the posing.live.live_targets.SnapWatch of its answers, or None
    frame    of the scene, that its last settled answer is of, or that it began at
    """

    binding: object = None
    bind_input: object = None
    native: object = None
    answer: object = None
    drafted: object = None
    snaps: object = None
    frame: float = 0.0


def begin_drag(binding, bind_input, shape=None):
    """A Drag from n x 3 `shape`, an earlier result; from rest where there is none, or what it holds are no numbers."""
    start = shape.astype(np.float64) if shape is not None and np.isfinite(shape).all() else None
    return Drag(binding, bind_input, binding.deformer.drag(bind_input.solver_mesh.start(start)), shape)


def solve_steps(drag, goal, settle=False, execution=None):
    """Steps (see solver/job.py) to (n x 3 float64 positions, native solution). What is mirrored is so to the last bit.

    goal: a bridge.targets.Targets; settle: see the native Deformer. The first result of a Drag is the same for the same
    arguments. It then goes on with what the solves before told, and is so within the tolerance.

    @throws SolverError, CancelledError.
    """
    mesh = drag.bind_input.solver_mesh
    solution = yield from steps(
        drag.native.start_solve,
        _targets(mesh, goal.positions),
        weights=_weights(mesh, goal.weights),
        settle=settle,
        execution=execution,
        refused=REFUSED_POSE,
    )
    positions = finite(solution.vertices, "Move the handles closer to the rest shape, or add pins")
    return mesh.cut_back(positions), solution


def draft(drag, goal):
    """What solve_steps() is going to give, at once: n x 3 float64, or None where too little is known of such a move.
    goal: a bridge.targets.Targets in which all anchors count."""
    mesh = drag.bind_input.solver_mesh
    try:
        shape = call(drag.native.draft, _targets(mesh, goal.positions))
    except SolverError:
        return None  # the solve of the same targets says why
    return None if shape is None or not np.isfinite(shape).all() else mesh.cut_back(shape)


def sequence_steps(binding, bind_input, targets, weights, *, execution=None, **options):
    """Steps (see solver/job.py) to (r x n x 3 float32, native Sequence) of rows of a clip.

    targets: f x k x 3 of the whole clip, in the order of the anchors; weights: f x k, 0 to 1, or None; options: others
    of the solver. Rows that could not be solved are told in its `errors`. @throws SolverError, CancelledError.
    """
    mesh = bind_input.solver_mesh
    sequence = yield from steps(
        binding.deformer.start_solve_sequence,
        _targets(mesh, targets),
        weights=_weights(mesh, weights),
        execution=execution,
        refused=REFUSED_POSE,
        **options,
    )
    return mesh.cut_back_rows(sequence.vertices), sequence


def _held(mesh, bind_input):
    """(anchors, arguments) for the solver, to whom a soft border is one more soft handle."""
    anchors, handles, strengths, border = mesh.anchors, mesh.handles, mesh.strengths, mesh.border
    if border is not None:
        strengths = np.append(np.full(len(handles), np.inf) if strengths is None else strengths, mesh.border_strengths)
        handles = np.append(handles, np.full(len(border), handles.max(initial=-1) + 1, np.int32))
        anchors = np.append(anchors, border)
    return anchors, {
        "handles": handles,
        "rigidity": bind_input.rigidity,
        "stiffness": mesh.stiffness,
        "strengths": strengths,
        "border": 0 if border is None else len(border),
    }


def _targets(mesh, positions):
    """Places of the anchors, (..., K, 3), and behind them those of the soft border, which are at rest."""
    positions = mesh.targets(np.asarray(positions, np.float64))
    if mesh.border is None:
        return np.ascontiguousarray(positions)
    rest = mesh.rest[mesh.border]
    return np.concatenate([positions, np.broadcast_to(rest, (*positions.shape[:-2], *rest.shape))], axis=-2)


def _weights(mesh, weights):
    """What each anchor counts, (..., K), and behind them those of the soft border, which count fully; None: all do."""
    weights = mesh.weights(weights)
    if weights is None or mesh.border is None:
        return weights
    return np.concatenate([weights, np.ones((*np.shape(weights)[:-1], len(mesh.border)))], axis=-1)


def steps(function, *arguments, refused=REFUSED_MESH, **options):
    """Steps (see solver/job.py) to what the native task comes to that `function` begins; as call()."""
    task = call(function, *arguments, refused=refused, **options)
    yield task
    return call(task.result, refused=refused)


def finite(positions, remedy):
    """@throws SolverError, with what to do, if `positions` hold anything but numbers."""
    if not np.isfinite(positions).all():
        raise SolverError(f"The solver gave positions that are not numbers. {remedy}")
    return positions


def call(function, *arguments, refused=REFUSED_MESH, **options):
    """Calls the native module; its errors become ours, with what to do. refused: what is said of input."""
    module = native_loader.module()
    try:
        return function(*arguments, **options)
    except module.InvalidInput as error:
        raise SolverError(refused.format(error)) from error
    except module.SolverFailure as error:
        raise SolverError(f"The solver failed: {error}. Move the handles less, or add pins") from error
    except module.Cancelled as error:
        raise CancelledError("Cancelled. Nothing was changed") from error
    except module.TooLittleMemory as error:
        raise SolverError(f"Too little memory: {error}. Choose a smaller region") from error
    except MemoryError as error:
        raise SolverError("Too little memory. Choose a smaller region, or close other programs") from error
