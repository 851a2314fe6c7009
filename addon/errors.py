# SPDX-License-Identifier: GPL-3.0-or-later
"""What can go wrong, one class per kind of blame. Every message says what is wrong and what to do about it."""


class MeanValueError(Exception):
    """Base of all: an operator reports it as {'ERROR'} and leaves the scene as it was."""


class SceneError(MeanValueError):
    """The scene is not ready; the artist can put it right."""


def require_none(problem):
    """@throws SceneError that says `problem`, if there is one."""
    if problem:
        raise SceneError(problem)


class InvalidMotionError(MeanValueError):
    """Motion capture data or settings that nothing sensible can be made of; the message says what to change."""


class MotionFileError(MeanValueError):
    """A motion capture file cannot be read: it is damaged, of another format, or has no markers."""


class ChangedMeanwhileError(SceneError):
    """An object was edited while a job worked on what had been read of it."""

    def __init__(self, name):
        super().__init__(f"'{name}' was changed while it was worked on, so the result is dropped. Try again")


class StaleBindingError(SceneError):
    """The mesh is not the one that was bound."""


class NativeModuleError(MeanValueError):
    """The compiled solver cannot be loaded; the installation must be put right."""


class SolverError(MeanValueError):
    """The solver refused its input or failed."""


class CacheError(MeanValueError):
    """A file of a bake cannot be read or written: the disk is full, the folder is missing or protected."""


class DamagedCacheError(CacheError):
    """A file of a bake is not what was written."""


class CancelledError(MeanValueError):
    """The artist stopped the work; nothing was changed."""
