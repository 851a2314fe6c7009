# SPDX-License-Identifier: GPL-3.0-or-later
"""The layers point one way, and versions agree: checked on the sources."""

import ast
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
NATIVE = ROOT / "native"
CORE = ("include/", "meanvalue/", "reference/")
# A folder may include itself and those named here.
ALLOWED = {
    "common": set(),
    "mesh": {"common"},
    "encoding": {"common", "mesh"},
    "linalg": {"common"},
    "hierarchy": {"common", "mesh", "encoding", "linalg"},
    "optimise": {"common", "mesh", "encoding", "linalg"},
    "examples": {"common", "mesh", "encoding", "linalg"},
    "decode": {"common", "mesh", "encoding", "linalg", "hierarchy", "optimise", "examples"},
    "paper": {"common", "mesh", "encoding", "linalg", "hierarchy", "optimise", "decode"},
    "follow": {"common", "mesh", "encoding", "linalg", "hierarchy", "optimise", "examples", "decode"},
    "deform": {"common", "mesh", "encoding", "linalg", "hierarchy", "optimise", "examples", "decode", "paper"}
    | {"follow"},
    "sliders": {"common", "linalg"},
    "bones": {"common", "mesh", "linalg"},
    "transfer": {"common", "mesh", "linalg", "follow"},
    "sequence": {"common", "mesh", "encoding", "linalg", "hierarchy", "optimise", "decode", "deform"},
    "morph": {"common", "mesh", "encoding", "linalg", "hierarchy", "optimise", "decode", "deform", "follow"},
    "meanvalue.h": {"common", "deform", "follow", "sequence", "morph", "sliders", "bones", "transfer"},
    # What we are compared with; nothing of the product depends on it.
    "reference": {"common", "mesh", "encoding", "linalg", "hierarchy", "optimise", "decode"},
}


def sources(folder, *suffixes):
    found = [path for path in folder.rglob("*") if path.suffix in suffixes and "__pycache__" not in path.parts]
    assert found, f"nothing to check in {folder}"
    return found


def includes(path):
    return re.findall(r'^\s*#include\s+[<"]([^>"]+)[>"]', path.read_text(), re.MULTILINE)


def folder_of(path):
    """The part of the core that a file belongs to, by its path below native/ or as it is included."""
    return path.removeprefix("include/").removeprefix("meanvalue/").split("/")[0]


def imported_modules(path):
    """Names of all modules that a Python file imports, relative ones with their dots."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield "." * node.level + (node.module or "")


def test_core_includes_point_downwards():
    for path in (path for part in CORE for path in sources(NATIVE / part, ".h", ".cpp")):
        folder = folder_of(path.relative_to(NATIVE).as_posix())
        for include in includes(path):
            if include.startswith(CORE):
                below = folder_of(include)
                assert below == folder or below in ALLOWED[folder], f"{path} includes {include}"
                assert "include" not in path.parts or (NATIVE / "include" / include).exists(), f"{path} is public"
            assert not include.startswith(("pybind11/", "Python.h", "bindings/")), f"{path} includes {include}"


def test_openmesh_is_included_in_one_file_and_no_library_factors():
    users = {"OpenMesh/": set(), "Eigen/CholmodSupport": set(), "Eigen/SparseCholesky": set()}
    for path in sources(ROOT / "native", ".h", ".cpp"):
        for include in includes(path):
            for library, files in users.items():
                if include.startswith(library):
                    files.add(path.name)
    assert users == {"OpenMesh/": {"one_ring.cpp"}, "Eigen/CholmodSupport": set(), "Eigen/SparseCholesky": set()}


def test_reference_methods_are_included_by_bindings_tests_and_benchmarks_only():
    every = sources(NATIVE, ".h", ".cpp")
    users = {path.relative_to(NATIVE).parts[0] for path in every if '#include "reference/' in path.read_text()}
    assert users and users <= {"reference", "bindings", "tests", "benchmarks"}


ADDON = ROOT / "addon"

#: The rooms, each with those that it may use. Shared rooms know no feature.
SHARED = {"solver": set(), "scene": {"solver"}, "widgets": {"scene", "solver"}, "live": {"scene", "solver"}}
FEATURES = {
    "posing": set(),
    "mixing": set(),
    "wrapping": set(),
    "capture": {"posing"},
    "baking": {"posing"},
    "sliders": {"posing", "baking", "capture"},
}
ROOMS = SHARED | {room: set(SHARED) | others for room, others in FEATURES.items()}

#: What every room may use besides.
EVERYWHERE = {"compat", "errors", "ids", "rooms", "wording"}

#: Inside a room, from below; a module beside these folders comes above them, but what is kept, which operators read.
INSIDE = ("core", "bridge", "live", "properties", "operators")

#: Where each feature keeps what is its own in `object.meanvalue`.
KEPT = {
    "mix": "mixing",
    "wrap": "wrapping",
    "capture": "capture",
    "bake": "baking",
    "bake_values": "sliders",
    "drive": "sliders",
}


def imported_names(path):
    """What a file of the add-on imports from it, as tuples of names from addon/ on."""
    package = path.relative_to(ADDON).parts[:-1]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            above = package[: len(package) - node.level + 1]
            base = (*above, *node.module.split(".")) if node.module else above
            for name in node.names:
                yield (*base, name.name)


def height(parts):
    """Of a file, or of a module that is imported, in its room: a number that rises from core/ on."""
    inner = parts[1].removesuffix(".py") if len(parts) > 1 else ""
    return INSIDE.index(inner) if inner in INSIDE else len(INSIDE)


@pytest.mark.parametrize("room", ROOMS)
def test_rooms_know_what_they_may_know(room):
    wrong = []
    for path in sources(ADDON / room, ".py"):
        parts = path.relative_to(ADDON).parts
        for names in imported_names(path):
            is_allowed = names[0] in EVERYWHERE | ROOMS[room] | {room}
            if names[0] == room and room in FEATURES:
                is_allowed = height(names) <= height(parts)
            if "core" in parts:
                is_free = names[0] in ("errors", "wording") or names == ("solver", "native_loader")
                is_allowed = is_free or (is_allowed and "core" in names)
            if not is_allowed:
                wrong.append(f"{path.relative_to(ADDON)} imports {'.'.join(names)}")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("room", ROOMS)
def test_rooms_read_no_settings_of_others(room):
    for path in sources(ADDON / room, ".py"):
        for name in re.findall(r"\b(?:meanvalue|settings)\.(\w+)", path.read_text()):
            assert KEPT.get(name, room) == room, f"{path} uses meanvalue.{name}"


@pytest.mark.parametrize("room", ROOMS)
def test_a_core_knows_nothing_of_blender(room):
    core = ADDON / room / "core"
    for path in sources(core, ".py") if core.is_dir() else ():
        for module in imported_modules(path):
            assert module.split(".")[0] not in ("bpy", "bmesh", "mathutils"), f"{path} imports {module}"


def test_the_native_module_is_imported_in_one_file():
    importers_of_the_add_on = {"registration.py"}  # by the name that it has where it runs
    users = {
        path.name
        for path in sources(ROOT / "addon", ".py")
        if re.search(r"^\s*(import meanvalue|from meanvalue )|import_module\(", path.read_text(), re.MULTILINE)
    }
    assert users <= {"native_loader.py", *importers_of_the_add_on}
    assert "native_loader.py" in users


def test_only_compat_asks_for_blenders_version():
    for path in sources(ROOT / "addon", ".py"):
        if path.name not in ("compat.py",):
            assert "bpy.app.version" not in path.read_text().replace("bpy.app.version_string", ""), path


def test_versions_agree():
    cmake = re.search(r"project\(meanvalue VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
    for file in ("pyproject.toml", "packaging/blender_manifest.toml"):  # both take CMake's
        assert not re.search(r'^version = "', (ROOT / file).read_text(), re.MULTILINE), file
    bl_info = re.search(r'"version": \((\d+), (\d+), (\d+)\)', (ROOT / "addon/__init__.py").read_text())
    assert ".".join(bl_info.groups()) == cmake


def test_files_stay_short_enough_to_read():
    limits = [(path, 600) for path in sources(ROOT / "native", ".h", ".cpp") + sources(ROOT / "blender_tests", ".py")]
    limits += [(path, 300) for path in sources(ADDON, ".py")]
    assert [str(path) for path, most in limits if len(path.read_text().splitlines()) > most] == []
