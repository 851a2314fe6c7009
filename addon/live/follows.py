# SPDX-License-Identifier: GPL-3.0-or-later
"""What a follower has to define besides live/following.py, which says when each is called."""

import abc
from collections.abc import Callable, Iterable

from ..scene import object_model


class Follows(abc.ABC):
    READS: object_model.Kind
    FOLLOWS: str  # what moves it, in words
    LABEL: str
    AND_EXPORTS: str  # what to mind besides, behind "Bake first"

    @staticmethod
    @abc.abstractmethod
    def asks_for(obj) -> bool:
        """Whether it is turned on for `obj`."""

    @staticmethod
    @abc.abstractmethod
    def turn(obj, is_on: bool):
        """The switch of that."""

    @staticmethod
    @abc.abstractmethod
    def is_animated(obj) -> bool:
        """Whether keyframes move what it follows. On any thread."""

    @staticmethod
    @abc.abstractmethod
    def why_hidden(obj) -> str | None:
        """Why nothing of it is to be seen, in words."""

    @abc.abstractmethod
    def notes(self) -> Iterable[str]:
        """What is wrong with what is shown, in sentences."""

    @abc.abstractmethod
    def _cached_binding(self, found):
        """What is bound of what was read, if it is at hand; else None."""

    @abc.abstractmethod
    def _bind_work(self, obj) -> Callable:
        """The work of a Job that ends in a function of the object, which takes the binding up."""

    @abc.abstractmethod
    def _solve_work(self, obj, settles: bool) -> Callable:
        """The same for the answer to what is wanted; settles: it is the last word."""

    @abc.abstractmethod
    def _read_targets(self, obj):
        """What is wanted now. @throws MeanValueError."""

    @abc.abstractmethod
    def _is_same_target(self, first, second) -> bool:
        """Of two that _read_targets() gave."""

    @abc.abstractmethod
    def _make_key(self, obj):
        """Makes the key that it writes."""
