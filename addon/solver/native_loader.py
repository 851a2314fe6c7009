# SPDX-License-Identifier: GPL-3.0-or-later
"""The only file that imports the compiled module, and not before it is needed: without it the panel says what is
missing."""

import contextlib
import importlib
import importlib.machinery
import pathlib
import platform

from ..errors import NativeModuleError

ADDON = __package__.rpartition(".")[0]

#: A module beside the add-on (legacy zip), then one that is installed on its own (wheel of an extension).
MODULE_NAMES = (f"{ADDON}.lib.meanvalue", "meanvalue")

_module = None
_problem = None


def module():
    """The compiled module. @throws NativeModuleError, and looks again at the next call."""
    global _module, _problem
    if _module is None:
        try:
            _module, _problem = _load(), None
        except NativeModuleError as error:
            _problem = str(error)
            raise
    return _module


def problem():
    """Why the compiled module cannot be used, or None. For drawing: looks once and keeps the answer."""
    if _module is None and _problem is None:
        with contextlib.suppress(NativeModuleError):
            module()
    return _problem


def forget():
    """Look again at the next call, as after an installation."""
    global _module, _problem
    _module = _problem = None


def environment():
    """(label, value) of what a compiled module must fit."""
    return (
        ("Python", platform.python_version()),
        ("Module suffix", importlib.machinery.EXTENSION_SUFFIXES[0]),
        ("Platform", f"{platform.system()} {platform.machine()}"),
    )


def _load():
    failures = []
    for name in MODULE_NAMES:
        try:
            found = importlib.import_module(name)
        except ImportError as error:
            is_absent = isinstance(error, ModuleNotFoundError) and f"{name}.".startswith(f"{error.name}.")
            failures += [] if is_absent else [str(error)]  # it is there, but the system cannot load it
            continue
        if hasattr(found, "Deformer") and hasattr(found, "find_snaps"):
            return found
        failures.append(f"a module '{name}' was found that is not this version's solver: {found}")
    raise NativeModuleError(_explanation(failures))


def _explanation(failures):
    bundled = sorted(path.name for path in (pathlib.Path(__file__).parents[1] / "lib").glob("meanvalue.*"))
    if failures:
        problem = f"The solver is installed but cannot be loaded ({'; '.join(failures)})"
    elif bundled:
        problem = f"The solver of this add-on is for another Python: it has {', '.join(bundled)}"
    else:
        problem = "The compiled solver is missing"
    here = ", ".join(f"{label} {value}" for label, value in environment())
    # As packaging/build_extension.py calls the extension's zip for this system.
    system = {"Darwin": "macos"}.get(platform.system(), platform.system().lower())
    machine = platform.machine().lower()
    processor = {"amd64": "x64", "x86_64": "x64", "aarch64": "arm64"}.get(machine, machine)
    ending = f"{system}_{processor}.zip"
    zips = f"for Blender 4.2 and later one whose name ends in {ending}, else one with a solver in its lib folder"
    return f"{problem}. This Blender has {here}. Install the zip made for it: {zips}"
