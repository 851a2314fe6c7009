# SPDX-License-Identifier: GPL-3.0-or-later
"""packaging/: what the extension's zip holds, which wheels are refused and which made again, libraries for macOS."""

import hashlib
import importlib.util
import os
import pathlib
import struct
import sys
import zipfile

import pytest

tomllib = pytest.importorskip("tomllib", reason="needs Python 3.11")

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "packaging"))
import own_symbols  # noqa: E402


def loaded(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def builder():
    return loaded(ROOT / "packaging" / "build_extension.py")


@pytest.fixture
def wheels(builder, tmp_path):
    """Makes files that are called as wheels are, of this version."""

    def make(*tags, version=None):
        paths = [tmp_path / f"meanvalue-{version or builder.version()}-{tag}.whl" for tag in tags]
        for path in paths:
            path.write_bytes(b"wheel")
        return paths

    return make


LINUX_311 = "cp311-cp311-manylinux_2_27_x86_64.manylinux_2_28_x86_64"
LINUX_313 = "cp313-cp313-manylinux_2_28_x86_64"


def test_the_zip_holds_addon_manifest_wheels_and_licences(builder, wheels, tmp_path):
    (path,) = builder.build_all(tmp_path / "out", wheels(LINUX_313, LINUX_311))
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    assert len(names) == len(set(names))
    expected = {"__init__.py", "solver/native_loader.py", "scene/core/motion.py", "manual/guide/grab.html", "NOTICE"}
    assert expected <= set(names)
    assert not any("__pycache__" in name or name.startswith("lib/") for name in names)
    assert manifest["version"] == builder.version()
    assert manifest["platforms"] == ["linux-x64"]
    assert len(manifest["wheels"]) == 2
    assert {name.removeprefix("./") for name in manifest["wheels"]} == {n for n in names if n.endswith(".whl")}


def test_there_is_a_zip_for_each_platform_and_one_for_all_that_is_not_too_large(builder, wheels, tmp_path, monkeypatch):
    macos = "cp311-cp311-macosx_11_0_arm64", "cp311-cp311-macosx_10_15_x86_64"
    made = wheels(LINUX_313, LINUX_311, "cp311-cp311-win_amd64", *macos)

    def contents():
        found = {}
        for path in builder.build_all(tmp_path / "out", made):
            with zipfile.ZipFile(path) as archive:
                manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
            end = path.name.removeprefix(f"meanvalue-{builder.version()}-extension")
            found[end] = manifest["platforms"], len(manifest["wheels"])
        assert len(list((tmp_path / "out").iterdir())) == len(found)
        return found

    single = {
        "-linux_x64.zip": (["linux-x64"], 2),
        "-macos_arm64.zip": (["macos-arm64"], 1),
        "-macos_x64.zip": (["macos-x64"], 1),
        "-windows_x64.zip": (["windows-x64"], 1),
    }
    assert contents() == {**single, ".zip": (["linux-x64", "macos-arm64", "macos-x64", "windows-x64"], 5)}
    monkeypatch.setattr(builder, "LARGEST_FOR_ALL", 1000)
    assert contents() == single


def test_the_manifest_keeps_blenders_rules(builder, wheels):
    manifest = tomllib.loads(builder.manifest(wheels(LINUX_311)))
    required = {"schema_version", "id", "version", "name", "tagline", "maintainer", "type", "license"}
    assert required | {"blender_version_min"} <= set(manifest)
    for text in (manifest["tagline"], *manifest["permissions"].values()):
        assert len(text) <= 64 and text[-1].isalnum()
    assert set(manifest["permissions"]) <= {"files", "network", "clipboard", "camera", "microphone"}


def test_the_same_sources_make_the_same_bytes(builder, wheels, tmp_path):
    made, first, second = wheels(LINUX_311), tmp_path / "first.zip", tmp_path / "second.zip"
    builder.build(first, made)
    os.utime(made[0], (1_000_000_000, 1_000_000_000))
    builder.build(second, made)
    assert first.read_bytes() == second.read_bytes()


def test_wheels_that_do_not_fit_are_refused(builder, wheels):
    with pytest.raises(ValueError, match="would have no solver"):
        builder.check([])
    with pytest.raises(ValueError, match=r"not a wheel of meanvalue"):
        builder.check(wheels(LINUX_311, version="99.0"))
    with pytest.raises(ValueError, match="two wheels for cp311 on linux-x64"):
        builder.check(wheels(LINUX_311, "cp311-cp311-linux_x86_64"))
    with pytest.raises(ValueError, match="does not have"):
        builder.check(wheels("cp311-cp311-musllinux_1_2_x86_64"))


# -- wheels of the module ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def maker():
    return loaded(ROOT / "packaging" / "build_wheels.py")


def test_a_wheel_is_made_again_only_when_what_it_is_made_of_has_changed(maker, tmp_path, monkeypatch):
    made = []

    def build(_work, output, _tools, _target, version, _parts):
        made.append(version)
        wheel = output / f"meanvalue-{version}.whl"
        wheel.write_bytes(b"wheel")
        return wheel

    monkeypatch.setattr(maker, "build", build)
    monkeypatch.setattr(maker, "digest", lambda: "one")
    output = tmp_path / "wheels"
    output.mkdir()

    def wanted(version="3.11"):
        return maker.build_if_changed(tmp_path, output, None, None, version, None)

    first = wanted()
    assert wanted() == first and made == ["3.11"]
    wanted("3.13")
    assert wanted() == first and made == ["3.11", "3.13"]
    first.unlink()
    assert wanted().exists() and len(made) == 3
    monkeypatch.setattr(maker, "digest", lambda: "another")
    wanted()
    assert len(made) == 4


def test_all_that_a_wheel_is_made_of_is_there(maker):
    assert [name for name in maker.SOURCES if not (ROOT / name).exists()] == []


def test_a_wheel_is_called_as_its_python_and_system_want(maker):
    called = {
        ("linux", "x86_64"): ("cpython-311-x86_64-linux-gnu.so", "cp311-cp311-manylinux_2_28_x86_64"),
        ("linux", "aarch64"): ("cpython-311-aarch64-linux-gnu.so", "cp311-cp311-manylinux_2_28_aarch64"),
        ("windows", "x86_64"): ("cp311-win_amd64.pyd", "cp311-cp311-win_amd64"),
        ("macos", "x86_64"): ("cpython-311-darwin.so", "cp311-cp311-macosx_11_0_x86_64"),
        ("macos", "aarch64"): ("cpython-311-darwin.so", "cp311-cp311-macosx_11_0_arm64"),
    }
    assert set(called) == set(maker.TARGETS)
    for key, (suffix, tags) in called.items():
        assert maker.TARGETS[key].suffix_of("3.11") == suffix
        owners = [target for target in maker.TARGETS.values() if target.owns(f"meanvalue-0.1.0-{tags}.whl", "3.11")]
        assert owners == [maker.TARGETS[key]]


def test_there_is_a_wheel_for_the_python_of_each_blender_that_is_tested(maker):
    others = loaded(ROOT / "blender_tests" / "other_blenders.py")
    pythons = {suite.python for suites in others.SUITES.values() for suite in suites}
    assert pythons == set(maker.SUITES)


def test_the_library_in_python_of_windows_is_as_its_dll_calls_it(maker):
    import wheel_parts

    older = "class Finder:\n    def invalidate_caches(cls):\n        pass\n"
    mended = wheel_parts.as_called(older)
    assert mended == older.replace("    def inv", "    @classmethod\n    def inv")
    assert wheel_parts.as_called(mended) == mended


# -- libraries for macOS -----------------------------------------------------------------------------------------------


PAGE = 4096


def library():
    """The bytes, and where the signature is."""
    commands = struct.pack("<2I10I", 0x80000022, 48, *range(1, 11)) + struct.pack("<4I", 0x1D, 16, PAGE, 0)
    header = struct.pack("<8I", own_symbols.MAGIC, 0x0100000C, 0, 6, 2, len(commands), 0x118085, 0)
    directory = struct.pack(">9I4B", own_symbols.CODE_DIRECTORY, 72, 0x20400, 2, 40, 0, 0, 1, PAGE, 32, 2, 0, 12)
    signature = struct.pack(">5I", 0xFADE0CC0, 92, 1, 0, 20) + directory + bytes(32)
    return bytearray((header + commands).ljust(PAGE, b"\1") + signature)


def test_nothing_is_looked_for_elsewhere_and_the_signature_fits():
    data = library()
    own_symbols.keep_to_own(data)
    assert struct.unpack_from("<I", data, 24)[0] == 0x100085
    assert struct.unpack_from("<10I", data, 40) == (1, 2, 3, 4, 0, 0, 7, 8, 9, 10)
    assert data[-32:] == hashlib.sha256(data[:PAGE]).digest()
    assert len(data) == len(library())


def test_what_is_no_such_library_or_signed_otherwise_is_refused():
    with pytest.raises(ValueError, match="no library for macOS"):
        own_symbols.keep_to_own(bytearray(b"\x7fELF" + bytes(64)))
    data = library()
    data[PAGE + 20 + 37] = 1
    with pytest.raises(ValueError, match="SHA-256"):
        own_symbols.keep_to_own(data)
