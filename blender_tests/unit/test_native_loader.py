# SPDX-License-Identifier: GPL-3.0-or-later
"""native_loader.py: which module is taken, and what is said if there is none."""

import sys
import types

import pytest
from support import installed


@pytest.fixture
def loader(part):
    loader = part("solver.native_loader")
    loader.forget()
    yield loader
    loader.forget()


@pytest.fixture
def nowhere(loader, monkeypatch):
    """No module can be found, and the add-on's folder has none either."""
    monkeypatch.setattr(loader, "MODULE_NAMES", ("nowhere.meanvalue",))
    monkeypatch.setattr(loader, "__file__", "/nowhere/native_loader.py")


def test_the_module_that_was_installed_is_taken(loader):
    """In the folder of a legacy copy, on its own by an extension's wheel."""
    assert loader.module().__name__ == ("meanvalue" if installed.IS_EXTENSION else f"{installed.PACKAGE}.lib.meanvalue")
    assert loader.problem() is None


def test_no_module_at_all(loader, nowhere, part):
    with pytest.raises(part("errors").NativeModuleError) as caught:
        loader.module()
    message = str(caught.value)
    assert "The compiled solver is missing" in message
    assert "Install the add-on zip" in message
    for _, value in loader.environment():
        assert value in message
    assert loader.problem() == message


def test_a_module_for_another_python(loader, monkeypatch, tmp_path, part):
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "meanvalue.cpython-310-x86_64-linux-gnu.so").touch()
    monkeypatch.setattr(loader, "MODULE_NAMES", ("nowhere.meanvalue",))
    monkeypatch.setattr(loader, "__file__", str(tmp_path / "solver" / "native_loader.py"))
    with pytest.raises(part("errors").NativeModuleError, match=r"is for another Python: it has .*cpython-310"):
        loader.module()


def test_a_module_that_the_system_cannot_load(loader, monkeypatch, tmp_path, part):
    (tmp_path / "brokenmeanvalue.py").write_text("raise ImportError('libOpenMeshCore.so.9.0: cannot open')")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(loader, "MODULE_NAMES", ("brokenmeanvalue",))
    with pytest.raises(part("errors").NativeModuleError, match=r"cannot be loaded.*libOpenMeshCore"):
        loader.module()


def test_a_module_that_needs_what_is_not_there(loader, monkeypatch, tmp_path, part):
    (tmp_path / "needymeanvalue.py").write_text("import a_module_that_is_not_there")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(loader, "MODULE_NAMES", ("needymeanvalue",))
    with pytest.raises(part("errors").NativeModuleError, match=r"cannot be loaded.*a_module_that_is_not_there"):
        loader.module()


def test_another_module_of_that_name(loader, monkeypatch, part):
    monkeypatch.setitem(sys.modules, "impostor", types.ModuleType("impostor"))
    monkeypatch.setattr(loader, "MODULE_NAMES", ("impostor",))
    with pytest.raises(part("errors").NativeModuleError, match="'impostor' was found that is not the solver"):
        loader.module()


def test_a_module_on_its_own_is_the_second_choice(loader, monkeypatch):
    alone = types.ModuleType("alone")
    alone.Deformer = object
    monkeypatch.setitem(sys.modules, "alone", alone)
    monkeypatch.setattr(loader, "MODULE_NAMES", ("nowhere.meanvalue", "alone"))
    assert loader.module() is alone


def test_drawing_does_not_try_again_but_an_operator_does(loader, nowhere, monkeypatch, part):
    tried = []
    real = loader._load

    def load():
        tried.append(1)
        return real()

    monkeypatch.setattr(loader, "_load", load)
    for _ in range(3):
        assert loader.problem() is not None
    assert len(tried) == 1
    with pytest.raises(part("errors").NativeModuleError):
        loader.module()
    assert len(tried) == 2


def test_registering_does_not_load_the_module(loader):
    sys.modules[installed.PACKAGE].unregister()
    sys.modules[installed.PACKAGE].register()
    assert loader._module is None
