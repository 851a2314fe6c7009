# SPDX-License-Identifier: GPL-3.0-or-later
"""Which compiled module is taken, and what is said if there is none."""

import sys
import types

import pytest
from support import installed


@pytest.fixture
def only(part, monkeypatch, tmp_path):
    """only(name): the loader, where no other module than one of that name can be found."""
    loader = part("solver.native_loader")

    def install(*names):
        monkeypatch.setattr(loader, "MODULE_NAMES", names)
        monkeypatch.setattr(loader, "__file__", str(tmp_path / "solver" / "native_loader.py"))
        monkeypatch.syspath_prepend(str(tmp_path))
        loader.forget()
        return loader

    yield install
    loader.forget()


def assert_missing(loader, part, *texts):
    with pytest.raises(part("errors").NativeModuleError) as caught:
        loader.module()
    assert all(text in str(caught.value) for text in texts), str(caught.value)
    assert loader.problem() == str(caught.value)


def test_the_module_that_was_installed_is_taken(part):
    """In the folder of a legacy copy, on its own by an extension's wheel."""
    loader = part("solver.native_loader")
    assert loader.module().__name__ == ("meanvalue" if installed.IS_EXTENSION else f"{installed.PACKAGE}.lib.meanvalue")
    assert loader.problem() is None
    assert not hasattr(loader.module(), "baselines"), "methods to compare with are for tests and benchmarks"


def test_no_module_at_all(only, part):
    loader = only("nowhere.meanvalue")
    assert_missing(loader, part, "Install", *(value for _, value in loader.environment()))


@pytest.mark.parametrize(
    ("system", "machine", "ending"),
    [
        ("Linux", "x86_64", "linux_x64.zip"),
        ("Linux", "aarch64", "linux_arm64.zip"),
        ("Windows", "AMD64", "windows_x64.zip"),
        ("Darwin", "x86_64", "macos_x64.zip"),
        ("Darwin", "arm64", "macos_arm64.zip"),
    ],
)
def test_without_a_module_the_zip_that_fits_is_named(only, part, monkeypatch, system, machine, ending):
    loader = only("nowhere.meanvalue")
    monkeypatch.setattr(loader.platform, "system", lambda: system)
    monkeypatch.setattr(loader.platform, "machine", lambda: machine)
    assert_missing(loader, part, f"ends in {ending}")


def test_a_module_for_another_python(only, part, tmp_path):
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "meanvalue.cpython-310-x86_64-linux-gnu.so").touch()
    assert_missing(only("nowhere.meanvalue"), part, "cpython-310")


@pytest.mark.parametrize(
    "source, named",
    [
        ("raise ImportError('libstdc++.so.6: cannot open')", "libstdc++"),
        ("import a_module_that_is_not_there", "a_module_that_is_not_there"),
        ("", "brokenmeanvalue"),  # another module of that name
    ],
)
def test_a_module_that_cannot_be_used(only, part, tmp_path, source, named):
    sys.modules.pop("brokenmeanvalue", None)
    (tmp_path / "brokenmeanvalue.py").write_text(source)
    assert_missing(only("brokenmeanvalue"), part, named)


def test_a_module_on_its_own_is_the_second_choice(only, monkeypatch):
    alone = types.ModuleType("alone")
    alone.Deformer = alone.find_snaps = object
    monkeypatch.setitem(sys.modules, "alone", alone)
    assert only("nowhere.meanvalue", "alone").module() is alone
