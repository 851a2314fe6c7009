# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs pytest where `bpy` is: inside Blender, or in a Python that has the bpy module.

    blender -b --factory-startup -noaudio --python-exit-code 1 --python blender_tests/run.py -- ARGS
    PYTHON_WITH_BPY blender_tests/run.py -- ARGS

ARGS go to pytest; without a path among them, unit/ and scenarios/ are run. Environment:

    MEANVALUE_ADDON_ZIP    the add-on zip to install and test (required)
    BLENDER_USER_SCRIPTS   folder of its own to install into (required inside Blender; made here for the bpy module)
"""

import os
import pathlib
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent


def pytest_arguments(arguments):
    own = arguments[arguments.index("--") + 1 :] if "--" in arguments else []
    has_path = any(pathlib.Path(argument.split("::")[0]).exists() for argument in own)
    return own if has_path else [*own, str(HERE / "unit"), str(HERE / "scenarios")]


def run(arguments):
    import pytest

    status = pytest.main(["-p", "no:cacheprovider", *pytest_arguments(arguments)])
    sys.stdout.flush()
    return int(status)


def main():
    if "bpy" in sys.modules:
        return run(sys.argv)
    # The bpy module reads the environment when it is imported, so the folders must be there before.
    with tempfile.TemporaryDirectory(prefix="meanvalue-tests-") as folder:
        for name in ("SCRIPTS", "CONFIG", "DATAFILES", "EXTENSIONS"):
            os.environ.setdefault(f"BLENDER_USER_{name}", str(pathlib.Path(folder, name.lower())))
        pathlib.Path(os.environ["BLENDER_USER_SCRIPTS"]).mkdir(parents=True, exist_ok=True)
        import bpy  # noqa: F401  the tests find it in sys.modules

        return run(sys.argv)


if __name__ == "__main__":
    status = main()
    if status:
        sys.exit(status)
