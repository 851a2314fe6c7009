# SPDX-License-Identifier: GPL-3.0-or-later
"""What a feature brings: its room.py fills a Room, which registration.py takes in. A wrong name fails at once, and what
lacks a part of its contract. Shared rooms, and those that a feature builds on, call what is in ALL, and know no
feature."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, fields
from types import ModuleType
from typing import Any, Protocol, runtime_checkable


@runtime_checkable
class Follows(Protocol):
    """A class of followers, derived from that in live/following.py, which calls these. The first four are static."""

    READS: Any  # as a Kind of scene/object_model.py
    FOLLOWS: str  # what moves it, in words
    LABEL: str
    AND_EXPORTS: str  # what to mind besides, behind "Bake first"

    def asks_for(self, obj) -> bool:
        """Whether it is turned on for `obj`."""

    def turn(self, obj, is_on: bool):
        """The switch of that."""

    def is_animated(self, obj) -> bool:
        """Whether keyframes move what it follows. On any thread."""

    def why_hidden(self, obj) -> str | None:
        """Why nothing of it is to be seen, in words."""

    def notes(self) -> Iterable[str]:
        """What is wrong with what is shown, in sentences."""

    def _cached_binding(self, found):
        """What is bound of what was read, if it is at hand; else None."""

    def _bind_work(self, obj) -> tuple[Callable, Callable]:
        """(the work of a Job that binds, what takes its result up: a function of the object and that)."""

    def _solve_work(self, obj, settles: bool) -> tuple[Callable, Callable]:
        """The same for the answer to what is wanted; settles: it is the last word."""

    def _read_targets(self, obj):
        """What is wanted now. @throws MeanValueError."""

    def _is_same_target(self, first, second) -> bool:
        """Of two that _read_targets() gave."""

    def _make_key(self, obj):
        """Makes the key that it writes."""


@runtime_checkable
class ShownKeys(Protocol):
    """Shape keys that may show the pose in place of the result."""

    def names(self, obj) -> list[str]:
        """Of those that do; none where the result does."""

    def positions(self, obj):
        """n x 3 float32: the mesh as they show it; None where the result does."""

    def keyframe(self, obj) -> tuple[int, str] | None:
        """Keys them at the current frame. (count, what it was), None where controls are keyed. @throws SceneError."""


@runtime_checkable
class Bakeable(Protocol):
    """What can be baked besides handles."""

    def is_meant(self, obj) -> bool:
        """Whether it is this that shapes `obj`, or whose bake plays in its place: cheap."""

    def bind(self, obj):
        """In place of a Posing: with bind_input (which has rest, diagonal and revision, a digest of it), binding,
        record(), work() and require_unchanged(). @throws SceneError."""

    def row(self, obj, bind_input):
        """(k,) float64: what the shape at the frame that is current depends on. @throws SceneError."""

    def solve_steps(self, binding, bind_input, row, execution):
        """Steps (see solver/job.py) to one shape, with positions (n x 3) and converged. @throws MeanValueError."""

    def shown_keys(self, obj) -> list:
        """The shape keys that show it, to be muted while the bake plays."""

    def animated(self, obj) -> list:
        """The datablocks whose keyframes move it."""

    def is_on(self, obj) -> bool:
        """Whether the mesh follows it at once."""

    def turn(self, obj, is_on: bool):
        """The switch of that."""


@dataclass
class Hooks:
    """Functions of an object, unless it says otherwise, and contracts that others call."""

    finders: Sequence[Callable] = ()  # to the mesh object that it stands for, as a control does, or None
    followers: Sequence[Follows] = ()  # one that is derived from another takes its place
    shown_keys: Sequence[ShownKeys] = ()
    bakeables: Sequence[Bakeable] = ()
    painters: Sequence[Callable] = ()  # of (context, mesh object): what is drawn over it in 3D Views
    tops: Sequence[Callable] = ()  # of (layout, context, object), over the main panel; True: nothing is below
    menus: Sequence[type] = ()  # at the end of the add-on's menu in Blender's Object menu
    blender_menus: Sequence[tuple] = ()  # (a menu of Blender's, the function that draws behind it)

    # What Blender tells; without arguments unless it says so. Nothing may go through all objects in the first.
    scene_updated: Sequence[Callable] = ()
    objects_changed: Sequence[Callable] = ()  # they came or went
    chosen: Sequence[Callable] = ()  # of the object that was made the active one, or taken to another mode
    another_file: Sequence[Callable] = ()
    about_to_save: Sequence[Callable] = ()
    forget: Sequence[Callable] = ()  # undo, redo or loading replaced everything that was read


@dataclass(kw_only=True)
class Room(Hooks):
    """page: of the guide; pages: {operator: page} of others; modules: whose classes Blender is to know, in this order;
    settings: {name in `object.meanvalue`: property}; of_collections: what `collection.meanvalue` is."""

    page: str
    modules: tuple[ModuleType, ...]
    settings: dict[str, Any] = field(default_factory=dict)
    of_collections: type | None = None
    pages: dict[str, str] = field(default_factory=dict)
    register: Callable = lambda: None
    unregister: Callable = lambda: None

    def __post_init__(self):
        contracts = (self.followers, Follows), (self.shown_keys, ShownKeys), (self.bakeables, Bakeable)
        unfinished = [each for found, contract in contracts for each in found if not isinstance(each, contract)]
        if unfinished:
            raise TypeError(f"{unfinished} lack what their contract wants")

    @property
    def classes(self):
        return [*classes_in(self.modules), *self.menus]


def classes_in(modules, prefix="MEANVALUE_"):
    """[class] that modules define with such a name, in their order."""
    found = [(module.__name__, each) for module in modules for each in vars(module).values() if isinstance(each, type)]
    return [each for home, each in found if each.__module__ == home and each.__name__.startswith(prefix)]


ALL = Hooks()


def take_in(rooms):
    """Has ALL be what rooms brought, in their order."""
    for name in [each.name for each in fields(Hooks)]:
        setattr(ALL, name, [item for room in rooms for item in getattr(room, name)])
