# SPDX-License-Identifier: GPL-3.0-or-later
"""The files in addon/translations against the strings of the sources: none missing, none stale, same places to fill."""

import importlib.util
import json
import pathlib
import re
import string
import sys
import types

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from support import ui_strings

from addon.core import language, line_breaks, wording

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILES = sorted((ROOT / "addon" / "translations").glob("*.po"))
LANGUAGES = ["de", "fr", "ja", "zh_HANS"]
NAMES, DESCRIPTIONS, MESSAGES = ui_strings.find()
WANTED = {**NAMES, **DESCRIPTIONS, **MESSAGES}


@pytest.fixture(scope="module")
def reader():
    """addon/translations, whose reader of files needs nothing of Blender."""
    path = ROOT / "addon" / "translations" / "__init__.py"
    had = sys.modules.get("bpy")
    sys.modules["bpy"] = types.ModuleType("bpy")
    sys.modules["addon.compat"] = types.ModuleType("addon.compat")
    import addon

    addon.compat = sys.modules["addon.compat"]
    try:
        spec = importlib.util.spec_from_file_location("addon.translations", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    finally:
        del sys.modules["addon.compat"], addon.compat
        if had is None:
            del sys.modules["bpy"]
    return module


def places(text):
    return sorted(field for _, field, _, _ in string.Formatter().parse(text) if field is not None)


def test_there_is_a_file_for_each_language():
    assert [path.stem for path in FILES] == LANGUAGES


def test_strings_of_all_kinds_are_found():
    assert ("Operator", "Add Handle") in NAMES and ("*", "Region") in NAMES and ("*", "Shape Key") in NAMES
    assert ("Operator", "Grab Tool") in NAMES and ("*", "Fill Gaps up to") in NAMES and ("Operator", "Wrap") in NAMES
    assert ("*", "Forget the binding. Handles, region and shape keys stay as they are") in DESCRIPTIONS
    assert ("*", "What the animation of the handles becomes") in DESCRIPTIONS
    assert ("*", "Bound: {summary}") in MESSAGES and ("*", "{count} vertices") in MESSAGES
    assert min(len(NAMES), len(DESCRIPTIONS)) > 150 and len(MESSAGES) > 50


def test_messages_are_written_out_where_they_are_translated():
    """A name in place of the text would be found by no script."""
    for path in (ROOT / "addon").rglob("*.py"):
        for call in re.findall(r"(?<!def )\btranslated\(\s*(\S)", path.read_text()):
            assert call in "\"'", path


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_string_is_translated_and_none_is_stale(reader, path):
    translations = reader.read(path)
    missing = sorted(f"{file}: {key}" for key, file in WANTED.items() if key not in translations)
    assert missing == []
    assert sorted(key for key in translations if key not in WANTED) == []


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_places_to_fill_are_the_same(reader, path):
    for (_context, english), translation in reader.read(path).items():
        assert places(translation) == places(english), english
        assert translation.count("\n") == english.count("\n"), english
        assert translation.strip() == translation, english
        assert english.endswith((".", ":")) == translation.endswith((".", "。", ":")), english


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_files_are_sorted_and_say_each_thing_once(reader, path):
    text = path.read_text(encoding="utf-8")
    keys = [
        (json.loads(context) if context else "*", json.loads(english))
        for context, english in re.findall(r'^(?:msgctxt (".*")\n)?msgid (".+")$', text, re.MULTILINE)
        if english != '""'
    ]
    assert keys == sorted(set(keys)) and set(keys) == set(reader.read(path))


def test_long_texts_and_comments_are_read(reader, tmp_path):
    path = tmp_path / "xx.po"
    path.write_text(
        '# note\nmsgid ""\nmsgstr "header"\n\nmsgctxt "Operator"\nmsgid "A "\n"\\"b\\""\nmsgstr ""\n"C\\n"\n"d"\n\n'
        'msgid "not yet"\nmsgstr ""'
    )
    assert reader.read(path) == {("Operator", 'A "b"'): "C\nd"}


def test_messages_are_looked_up_and_then_filled():
    german = {"{count} vertices": "{count} Vertices"}
    language.use(lambda text: german.get(text, text))
    try:
        assert wording.vertices(1200) == "1,200 Vertices" and wording.vertices(1) == "1 vertex"
    finally:
        language.use(str)
    assert wording.vertices(1200) == "1,200 vertices"
    assert language.translated("Braces {stay} without values") == "Braces {stay} without values"


def test_full_stops_are_those_of_the_script():
    assert wording.sentence("press Bind") == wording.sentence("Press Bind.") == "Press Bind."
    for japanese in ("ボタンを押す", "ボタンを押す。"):
        assert wording.sentence(japanese) == "ボタンを押す。"
    assert wording.sentence("ソルバー 1.0") == "ソルバー 1.0." and wording.sentence("") == "."


@pytest.mark.parametrize("width", [1, 16, 30])
def test_lines_without_spaces_are_broken(width):
    text = "グラブツールを選び、メッシュを押します。または編集モードで (Edit Mode)「ハンドル追加」を押します。"
    lines = line_breaks.wrap(text, width)
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")
    assert not any(line[0] in "、。)」" or line[-1] in "「" for line in lines)
    assert width < 16 or all(line_breaks.columns(line) <= width + 2 for line in lines)
    assert line_breaks.wrap("one two three", 8) == ["one two", "three"] and line_breaks.wrap("", 8) == []
