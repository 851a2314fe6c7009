# SPDX-License-Identifier: GPL-3.0-or-later
"""Which scenarios there are, without importing them: that needs Blender."""

import ast
import pathlib

FOLDER = pathlib.Path(__file__).resolve().parents[1]


def scenario_files():
    return sorted(path for path in FOLDER.glob("*.py") if not path.name.startswith(("test_", "conftest")))


def scenarios(path):
    """Names of the functions at the top of a file whose first argument is `ui`, in order; not those with a `_`."""
    functions = [node for node in ast.parse(path.read_text()).body if isinstance(node, ast.FunctionDef)]
    return [
        function.name
        for function in functions
        if not function.name.startswith("_") and [argument.arg for argument in function.args.args] == ["ui"]
    ]
