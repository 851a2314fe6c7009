# SPDX-License-Identifier: GPL-3.0-or-later
"""packaging/build_extension.py: what the extension's zip holds, and which wheels are refused."""

import importlib.util
import os
import pathlib
import zipfile

import pytest

tomllib = pytest.importorskip("tomllib", reason="needs Python 3.11")
ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def builder():
    spec = importlib.util.spec_from_file_location("build_extension", ROOT / "packaging" / "build_extension.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


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
    made = wheels(LINUX_313, LINUX_311, "cp311-cp311-win_amd64", "cp311-cp311-macosx_11_0_arm64")

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
        "-windows_x64.zip": (["windows-x64"], 1),
    }
    assert contents() == {**single, ".zip": (["linux-x64", "macos-arm64", "windows-x64"], 4)}
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


@pytest.mark.parametrize(
    ("tag", "platform"),
    [
        (LINUX_311, "linux-x64"),
        ("cp311-cp311-linux_x86_64", "linux-x64"),
        ("cp311-cp311-win_amd64", "windows-x64"),
        ("cp311-cp311-macosx_11_0_arm64", "macos-arm64"),
        ("cp311-cp311-macosx_10_15_x86_64", "macos-x64"),
    ],
)
def test_platforms_are_called_as_blender_does(builder, wheels, tag, platform):
    assert builder.platform(wheels(tag)[0]) == platform


def test_wheels_that_do_not_fit_are_refused(builder, wheels):
    with pytest.raises(ValueError, match="would have no solver"):
        builder.check([])
    with pytest.raises(ValueError, match=r"not a wheel of meanvalue"):
        builder.check(wheels(LINUX_311, version="99.0"))
    with pytest.raises(ValueError, match="two wheels for cp311 on linux-x64"):
        builder.check(wheels(LINUX_311, "cp311-cp311-linux_x86_64"))
    with pytest.raises(ValueError, match="does not have"):
        builder.check(wheels("cp311-cp311-musllinux_1_2_x86_64"))
