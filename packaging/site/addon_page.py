# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/reference/addon.md: every operator, setting and panel, as the add-on declares them. Runs in Blender.

    blender -b --python packaging/site/addon_page.py -- FILE     writes the page
"""

import importlib
import os
import pathlib
import sys

import bpy

ROOT = pathlib.Path(__file__).resolve().parents[2]

HEAD = """# Operators, settings and panels

<!-- Written by `./dev docs reference` from the add-on's own declarations. Do not edit. -->

What the add-on declares, with the descriptions that Blender shows as tooltips. The [guide](../guide/grab.md) says how
it is used, [scripting](../guide/scripting.md) has examples. *Scripts* marks what the interface does not show.
"""

#: What Blender says of the name that every item of a list has.
ANY_NAME = "Unique name used in the code and scripting"


def page(classes):
    """The text. classes: what the add-on has registered, in that order."""
    operators = [each for each in classes if issubclass(each, bpy.types.Operator)]
    operators.sort(key=lambda each: each.bl_idname)
    panels = [each for each in classes if issubclass(each, bpy.types.Panel)]
    assert operators and panels
    return "\n".join([HEAD, *_operators(operators), *_settings(), *_panels(panels)]).rstrip() + "\n"


def _operators(classes):
    yield "## Operators\n"
    yield "`bpy.ops.meanvalue.NAME(...)`, with their arguments and defaults; one that cannot run says why.\n"
    for cls in classes:
        rna = getattr(bpy.ops.meanvalue, cls.bl_idname.partition(".")[2]).get_rna_type()
        yield f"### {rna.name}\n"
        yield f"`{cls.bl_idname}` — {_sentence(rna.description)}\n"
        yield from _table(rna.properties, "argument")


def _settings():
    yield "## Settings\n"
    yield "What is kept on each object, and on the collection of an imported take.\n"
    for name, kind in (("object", bpy.types.Object), ("collection", bpy.types.Collection)):
        yield from _group(f"{name}.meanvalue", kind.bl_rna.properties["meanvalue"].fixed_type)


def _group(path, rna):
    yield f"### `{path}`\n"
    yield _sentence(_doc(rna)) + "\n"
    yield from _table(rna.properties, "setting")
    for each in listed(rna.properties):
        if _is_group(each):
            name = each.identifier + ("[i]" if each.type == 'COLLECTION' else "")
            yield from _group(f"{path}.{name}", each.fixed_type)


def _panels(classes):
    labels = {cls.__name__: cls.bl_label for cls in classes}
    yield "## Panels\n"
    yield "In the 3D View's sidebar (N), tab **Mean-Value**, as far as they have something to show.\n"
    yield "| panel | in | what it is for |\n|---|---|---|"
    for cls in classes:
        parent = labels.get(getattr(cls, "bl_parent_id", ""), "")
        description = cls.__dict__.get("__doc__") or ""
        yield f"| {cls.bl_label} | {parent} | {_cell(_sentence(description))} |"


def listed(properties):
    """Those that the add-on declares."""
    return [each for each in properties if each.identifier != "rna_type" and each.description != ANY_NAME]


def _table(properties, what):
    rows = listed(properties)
    if rows:
        yield f"| {what} | values | |\n|---|---|---|"
        yield from (f"| `{each.identifier}` | {_values(each)} | {_cell(_description(each))} |" for each in rows)
        yield ""


def _is_group(each):
    return each.type in {'POINTER', 'COLLECTION'} and each.fixed_type.identifier.startswith("MEANVALUE")


def _description(each):
    name = each.name if each.name != each.identifier else ""
    text = _sentence(each.description or (_doc(each.fixed_type) if _is_group(each) else name))
    if each.type == 'ENUM':
        items = [f"`{item.identifier}` {item.name}" + _tail(item.description) for item in each.enum_items_static]
        text = " ".join([text, "; ".join(items) + "." if items else ""]).strip()
    return f"{text} *Scripts.*".strip() if each.is_hidden else text


def _doc(rna):
    """The docstring of a group of settings."""
    classes = {cls.__name__: cls for cls in bpy.types.PropertyGroup.__subclasses__()}
    return classes[rna.identifier].__doc__ or ""


def _tail(description):
    return f": {description}" if description else ""


def _values(each):
    """Kind, default and range."""
    if each.type == 'BOOLEAN':
        return f"`{each.default}`" if not each.array_length else "booleans"
    if each.type in {'INT', 'FLOAT'}:
        kind = "integer" if each.type == 'INT' else "number"
        if each.array_length:
            return f"{each.array_length} {kind}s"
        low, high = (_bound(each.hard_min), _bound(each.hard_max))
        reach = f", {low} to {high}" if low and high else f", from {low}" if low else f", to {high}" if high else ""
        return f"{kind}, `{each.default:.6g}`{reach}"
    if each.type == 'STRING':
        return f'text, `"{each.default}"`'
    if each.type == 'ENUM':
        return f"`'{each.default}'`" if each.default else "choice"
    kind = each.fixed_type.identifier
    return "list" if each.type == 'COLLECTION' else "group" if _is_group(each) else kind


def _bound(value):
    return "" if abs(value) > 1e9 else f"{value:.6g}"


def _sentence(text):
    text = " ".join(text.split())
    return text.rstrip(".") + "." if text else ""


def _cell(text):
    return text.replace("|", "\\|").replace("\n", " ").replace("<", "&lt;")


def main():
    sys.path.insert(0, str(ROOT / "blender_tests"))
    from demo import pose

    pose.install_addon(os.environ["MEANVALUE_ADDON_ZIP"])
    classes = importlib.import_module(f"{pose.ADDON}.registration").CLASSES
    pathlib.Path(sys.argv[sys.argv.index("--") + 1]).write_text(page(classes))


if __name__ == "__main__":
    main()
