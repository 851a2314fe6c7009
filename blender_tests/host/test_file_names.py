# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/scene/core/: names and files as Windows takes them, asked on any system."""

import pathlib

import pytest

from addon.errors import CacheError
from addon.scene.core import whole_files
from addon.scene.core.whole_files import file_name


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Tube", "Tube"),
        ("CON", "CON_"),
        ("nul", "nul_"),
        ("Com1.chunks", "Com1_.chunks"),
        ("CONE", "CONE"),
        ("Walk.001", "Walk.001"),
        ("Walk...", "Walk"),
        ("Walk. ", "Walk"),
        ("a:b", "a_b"),
        ("a\0b\n", "a_b_"),
        ("...", "_"),
        ("手", "手"),
    ],
)
def test_names_that_every_system_takes(name, expected):
    assert file_name(name) == expected
    assert file_name(expected) == expected
    assert not pathlib.PureWindowsPath(expected + ".pc2").is_reserved()


def open_elsewhere(times, monkeypatch):
    """Renames fail so often, as they do on Windows while a program has the file open."""
    rename, failures = pathlib.Path.replace, [32] * times
    monkeypatch.setattr(whole_files.time, "sleep", lambda _seconds: None)

    def replace(self, target):
        if failures:
            error = PermissionError(13, "The process cannot access the file")
            error.winerror = failures.pop()
            raise error
        return rename(self, target)

    monkeypatch.setattr(pathlib.Path, "replace", replace)


def write(path, content):
    with whole_files.replacing(path) as file:
        file.write(content)


def test_a_file_that_is_open_elsewhere_is_waited_for(tmp_path, monkeypatch):
    write(tmp_path / "a", b"old")
    open_elsewhere(3, monkeypatch)
    write(tmp_path / "a", b"new")
    assert (tmp_path / "a").read_bytes() == b"new"


def test_a_file_that_stays_open_elsewhere_stays_as_it_is(tmp_path, monkeypatch):
    write(tmp_path / "a", b"old")
    open_elsewhere(100, monkeypatch)
    with pytest.raises(CacheError, match="another program has it open"):
        write(tmp_path / "a", b"new")
    assert (tmp_path / "a").read_bytes() == b"old"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
