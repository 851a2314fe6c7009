# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/reference/python.md: the module `meanvalue`, signatures from its type stubs and text from its docstrings.

    PYTHONPATH=build/python python3 packaging/site/python_page.py FILE     writes the page
"""

import ast
import inspect
import pathlib
import re
import sys

import meanvalue

ROOT = pathlib.Path(__file__).resolve().parents[2]
STUBS = ROOT / "native" / "bindings" / "stubs" / "meanvalue-stubs"

HEAD = """# Python module

<!-- Written by `./dev docs reference` from stubs and docstrings; a test compares. Do not edit. -->

`import meanvalue` works without Blender ([installing](../installing.md#the-python-module)). Arrays are numpy's, or
what numpy can make one of.
"""


def page():
    parts = [HEAD]
    for module, file in ((meanvalue, "__init__.pyi"), (meanvalue.baselines, "baselines.pyi")):
        parts.append(f"## `{module.__name__}`\n\n{prose(module.__doc__)}\n")
        for statement in ast.parse((STUBS / file).read_text()).body:
            if isinstance(statement, ast.ClassDef):
                parts += _class(statement, getattr(module, statement.name))
            elif isinstance(statement, ast.FunctionDef):
                parts += _function("###", statement.name, statement, getattr(module, statement.name))
    return "\n".join(parts).rstrip() + "\n"


def _class(statement, cls):
    bases = ", ".join(ast.unparse(base) for base in statement.bases)
    yield f"### {statement.name}\n"
    yield (prose(cls.__doc__) if cls.__doc__ else f"Raised; a `{bases}`.") + "\n"
    properties = []
    for member in statement.body:
        if not isinstance(member, ast.FunctionDef):
            continue
        if any(ast.unparse(each) == "property" for each in member.decorator_list):
            properties.append(_row(member, inspect.cleandoc(getattr(cls, member.name).__doc__ or "")))
        elif member.name == "__init__":
            yield from _function("####", statement.name, member, cls.__init__)
        elif not member.name.startswith("_"):
            yield from _function("####", f"{statement.name}.{member.name}", member, getattr(cls, member.name))
    if properties:
        yield "\n".join(["| property | type | |", "|---|---|---|", *properties]) + "\n"


def _row(member, text):
    """Of a property. Docstrings repeat its type."""
    text = re.sub(r"^[\w ().,-]+: ", "", " ".join(text.split()))
    text = text.replace("|", "\\|").replace("*", "\\*").replace("<", "&lt;")
    return f"| `{member.name}` | `{ast.unparse(member.returns)}` | {text} |"


def _function(level, name, statement, function):
    yield f"{level} {name}()\n"
    yield f"```python\n{signature(name, statement)}\n```\n"
    yield prose(_without_signature(inspect.getdoc(function) or "")) + "\n"


def signature(name, statement):
    """As the stub has it, without self; one argument a line where it is long."""
    statement.args.args = [each for each in statement.args.args if each.arg != "self"]
    arguments = re.sub(r"(?<=[\w\])])=(?=\S)", " = ", ast.unparse(statement.args))
    returns = "" if name.split(".")[-1][0].isupper() else f" -> {ast.unparse(statement.returns)}"
    line = f"{name}({arguments}){returns}"
    if len(line) <= 100:
        return line
    broken = re.sub(r", (?=\*|\w+:)", ",\n    ", arguments)
    return f"{name}(\n    {broken},\n){returns}"


def _without_signature(text):
    first, _, rest = text.partition("\n")
    return rest if re.match(r"\w+\(.*\)( -> .*)?$", first) else text


def prose(text):
    """A docstring as Markdown: what begins with `name: ` becomes a line of a list."""
    lines = []
    for line in inspect.cleandoc(text or "").splitlines():
        line = line.strip().replace("*", "\\*").replace("<", "&lt;")
        argument = re.match(r"((?:[a-z_]+)(?:, [a-z_]+)*): (.*)", line)
        is_end = re.match(r"(Returns|Raises)\b", line)
        if argument:
            if lines and lines[-1] and not lines[-1].startswith(("* ", "  ")):
                lines.append("")
            lines.append(f"* **{argument[1]}**: {argument[2]}")
        elif is_end:
            lines += ["", line] if lines and lines[-1] else [line]
        elif lines and lines[-1].startswith(("* ", "  ")) and line:
            lines.append(f"  {line}")
        else:
            lines.append(line)
    return "\n".join(lines).strip()


if __name__ == "__main__":
    pathlib.Path(sys.argv[1]).write_text(page())
