# SPDX-License-Identifier: GPL-3.0-or-later
"""The strings that the add-on shows, read off its sources: what there is to translate.

A message is (context, English); the context is Blender's own, "Operator" for what stands on the button of an operator
and "*" for all else.
"""

import ast
from pathlib import Path

ADDON = Path(__file__).resolve().parents[2] / "addon"
DEFAULT, OPERATOR = "*", "Operator"

#: Calls whose text is translated, with the context of that text.
DRAWN = {"label": DEFAULT, "prop": DEFAULT, "prop_search": DEFAULT, "menu": DEFAULT, "operator": OPERATOR}
SHOWN_CLASSES = {"Operator", "Panel", "Menu"}

#: The same in every language, or the artist's to change.
NAMES = {"", "Mean-Value", "Mean-Value Grab", "X", "Y", "Z", "Hz"}


def find(addon=ADDON):
    """(names, descriptions, messages): dictionaries of (context, English) to the file that has it."""
    strings = ({}, {}, {})
    for path in sorted(addon.rglob("*.py")):
        if "presets" in path.relative_to(addon).parts:
            continue
        _Reader(path.relative_to(addon).as_posix(), *strings).visit(ast.parse(path.read_text(encoding="utf-8")))
    return strings


class _Reader(ast.NodeVisitor):
    def __init__(self, file, names, descriptions, messages):
        self._file, self._names, self._descriptions, self._messages = file, names, descriptions, messages

    def visit_ClassDef(self, node):
        fields = {
            statement.targets[0].id: statement.value
            for statement in node.body
            if isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name)
        }
        bases = {base.attr if isinstance(base, ast.Attribute) else getattr(base, "id", "") for base in node.bases}
        # The only other context that a class here asks for is that of operators.
        is_operator = bases & {"Operator", "WorkSpaceTool"} or "bl_translation_context" in fields
        if "bl_label" in fields:
            self._keep(self._names, OPERATOR if is_operator else DEFAULT, fields["bl_label"])
        self._keep(self._descriptions, DEFAULT, fields.get("bl_description"))
        if bases & SHOWN_CLASSES and ast.get_docstring(node) and "bl_label" in fields:
            self._descriptions.setdefault((DEFAULT, ast.get_docstring(node)), self._file)
        self.generic_visit(node)

    def visit_Assign(self, node):  # the items of an enumeration that has a name, as KINDS
        elements = node.value.elts if isinstance(node.value, ast.Tuple) else ()
        if elements and all(isinstance(item, ast.Tuple) and len(item.elts) == 3 for item in elements):
            self._items(node.value)
        self.generic_visit(node)

    def visit_Call(self, node):
        function = node.func
        name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
        given = {keyword.arg: keyword.value for keyword in node.keywords}
        if isinstance(function, ast.Call) and getattr(function.func, "id", "") == "aside":
            name = getattr(function.args[0], "id", "")
        if name.endswith("Property") and "name" in given and "HIDDEN" not in ast.dump(given.get("options", node.func)):
            self._keep(self._names, DEFAULT, given["name"])
            self._keep(self._descriptions, DEFAULT, given.get("description"))
            self._items(given.get("items"))
        elif name == "size_property":
            self._keep(self._descriptions, DEFAULT, node.args[0])
        elif name in DRAWN and "text" in given:
            self._keep(self._names, DRAWN[name], given["text"])
        elif name == "translated" and node.args:
            self._keep(self._messages, DEFAULT, node.args[0])
        self.generic_visit(node)

    def _items(self, items):
        for item in items.elts if isinstance(items, ast.Tuple | ast.List) else ():
            if isinstance(item, ast.Tuple):
                self._keep(self._names, DEFAULT, item.elts[1])
                self._keep(self._descriptions, DEFAULT, item.elts[2])

    def _keep(self, strings, context, value):
        if isinstance(value, ast.IfExp):
            self._keep(strings, context, value.body)
            self._keep(strings, context, value.orelse)
        elif isinstance(value, ast.Constant) and isinstance(value.value, str) and value.value not in NAMES:
            strings.setdefault((context, value.value), self._file)
