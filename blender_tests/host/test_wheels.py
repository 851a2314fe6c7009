# SPDX-License-Identifier: GPL-3.0-or-later
"""packaging/build_wheels.py: for which Pythons wheels are made, and when one is made again. Compiles nothing."""

import importlib.util
import pathlib

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def loaded(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def builder(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "packaging"))
    return loaded(ROOT / "packaging" / "build_wheels.py")


def test_a_wheel_is_made_again_only_when_what_it_is_made_of_has_changed(builder, tmp_path, monkeypatch):
    made = []

    def build(_work, output, _tools, _target, version, _parts):
        made.append(version)
        wheel = output / f"meanvalue-{version}.whl"
        wheel.write_bytes(b"wheel")
        return wheel

    monkeypatch.setattr(builder, "build", build)
    monkeypatch.setattr(builder, "digest", lambda: "one")
    output = tmp_path / "wheels"
    output.mkdir()

    def wanted(version="3.11"):
        return builder.build_if_changed(tmp_path, output, None, None, version, None)

    first = wanted()
    assert wanted() == first and made == ["3.11"]
    wanted("3.13")
    assert wanted() == first and made == ["3.11", "3.13"]
    first.unlink()
    assert wanted().exists() and len(made) == 3
    monkeypatch.setattr(builder, "digest", lambda: "another")
    wanted()
    assert len(made) == 4


def test_all_that_a_wheel_is_made_of_is_there(builder):
    assert [name for name in builder.SOURCES if not (ROOT / name).exists()] == []


def test_a_wheel_is_called_as_its_python_and_system_want(builder):
    called = {
        ("linux", "x86_64"): ("cpython-311-x86_64-linux-gnu.so", "cp311-cp311-manylinux_2_28_x86_64"),
        ("linux", "aarch64"): ("cpython-311-aarch64-linux-gnu.so", "cp311-cp311-manylinux_2_28_aarch64"),
        ("windows", "x86_64"): ("cp311-win_amd64.pyd", "cp311-cp311-win_amd64"),
        ("macos", "x86_64"): ("cpython-311-darwin.so", "cp311-cp311-macosx_11_0_x86_64"),
        ("macos", "aarch64"): ("cpython-311-darwin.so", "cp311-cp311-macosx_11_0_arm64"),
    }
    assert set(called) == set(builder.TARGETS)
    for key, (suffix, tags) in called.items():
        assert builder.TARGETS[key].suffix_of("3.11") == suffix
        owners = [target for target in builder.TARGETS.values() if target.owns(f"meanvalue-0.1.0-{tags}.whl", "3.11")]
        assert owners == [builder.TARGETS[key]]


def test_there_is_a_wheel_for_the_python_of_each_blender_that_is_tested(builder):
    others = loaded(ROOT / "blender_tests" / "other_blenders.py")
    pythons = {suite.python for suites in others.SUITES.values() for suite in suites}
    assert pythons == set(builder.SUITES)


def test_the_library_in_python_of_windows_is_as_its_dll_calls_it(builder):
    import wheel_parts

    older = "class Finder:\n    def invalidate_caches(cls):\n        pass\n"
    mended = wheel_parts.as_called(older)
    assert mended == older.replace("    def inv", "    @classmethod\n    def inv")
    assert wheel_parts.as_called(mended) == mended
