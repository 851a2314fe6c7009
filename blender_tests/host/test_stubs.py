# SPDX-License-Identifier: GPL-3.0-or-later
"""The type stubs tell what the compiled module has: names, parameters, defaults, and which are keywords."""

import ast
import inspect
import pathlib

import meanvalue
import pytest

STUBS = pathlib.Path(__file__).resolve().parents[2] / "native" / "bindings" / "stubs" / "meanvalue-stubs"
MODULES = [("meanvalue", "__init__.pyi"), ("meanvalue.baselines", "baselines.pyi")]


def parameters(function):
    """[(name, kind, default)] of an ast.FunctionDef, without annotations and without self."""
    given = function.args
    plain = [*given.posonlyargs, *given.args]
    without = [None] * (len(plain) - len(given.defaults))
    found = [
        (argument.arg, "plain", default and ast.unparse(default))
        for argument, default in zip(plain, [*without, *given.defaults], strict=True)
    ]
    found += [
        (argument.arg, "keyword", default and ast.unparse(default))
        for argument, default in zip(given.kwonlyargs, given.kw_defaults, strict=True)
    ]
    return [parameter for parameter in found if parameter[0] != "self"]


def declared(body):
    """{name: parameters, "property" or {...} of a class} of the statements of a stub."""
    names = {}
    for statement in body:
        if isinstance(statement, ast.ClassDef):
            names[statement.name] = declared(statement.body)
        elif isinstance(statement, ast.FunctionDef):
            is_property = any(ast.unparse(decorator) == "property" for decorator in statement.decorator_list)
            if not statement.name.startswith("__") or statement.name == "__init__":
                names[statement.name] = "property" if is_property else parameters(statement)
        elif isinstance(statement, ast.AnnAssign) and not statement.target.id.startswith("__"):
            names[statement.target.id] = "property"  # that can be set
    return names


def from_docstring(function):
    """The same as `parameters` of the signature that pybind11 puts into a docstring."""
    return parameters(ast.parse(f"def {function.__doc__.splitlines()[0]}: ...").body[0])


def present(container):
    names = {}
    for name, value in vars(container).items():
        if inspect.isclass(value):
            names[name] = {} if issubclass(value, Exception) else present(value)
        elif isinstance(value, property):
            names[name] = "property"
        elif (not name.startswith("_") or name == "__init__") and callable(value) and "->" in (value.__doc__ or ""):
            names[name] = from_docstring(value)
    return names


@pytest.mark.parametrize(("module", "file"), MODULES)
def test_stubs_say_what_the_module_has(module, file):
    stub = declared(ast.parse((STUBS / file).read_text(encoding="utf-8")).body)
    assert stub == present(pytest.importorskip(module, reason="built without methods to compare with"))
    assert len(stub) >= 5


def test_exceptions_derive_from_what_the_stubs_say():
    tree = ast.parse((STUBS / "__init__.pyi").read_text(encoding="utf-8"))
    said = {
        node.name: ast.unparse(node.bases[0]) for node in tree.body if isinstance(node, ast.ClassDef) and node.bases
    }
    assert set(said) == {"Cancelled", "InvalidInput", "SolverFailure", "TooLittleMemory"}
    for name, base in said.items():
        assert getattr(meanvalue, name).__bases__[0].__name__ == base
