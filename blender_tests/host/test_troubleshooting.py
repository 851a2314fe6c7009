# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/troubleshooting.md has an entry for every text that the add-on may show, and none for what nobody says."""

import ast

import pytest
from support import shown_texts

#: An entry that fits more messages than this says nothing about any of them.
MOST_MESSAGES = 7


@pytest.fixture(scope="module")
def texts():
    return [*shown_texts.of_addon(), *shown_texts.of_native()]


@pytest.fixture(scope="module")
def patterns():
    return shown_texts.entries()


def test_every_message_has_an_entry(texts, patterns):
    missing = sorted(
        f"{each.where}: {each.text}"
        for each in texts
        if shown_texts.says_something(each.text)
        and not any(shown_texts.matches(pattern, each.text) for _line, pattern in patterns)
    )
    advice = "add rows to docs/troubleshooting.md: `| *message, with … where something is filled in* | what to do |`"
    assert not missing, "\n".join([advice, *missing])


def test_every_entry_is_of_a_message(texts, patterns):
    stale = [
        f"line {line}: {pattern}"
        for line, pattern in patterns
        if not any(shown_texts.matches(pattern, each.text) for each in texts)
    ]
    assert not stale, "\n".join(["no message of the add-on is like these any more:", *stale])


def test_an_entry_is_of_few_messages(texts, patterns):
    said = {each.text for each in texts if shown_texts.says_something(each.text)}
    for line, pattern in patterns:
        fitting = [text for text in said if shown_texts.matches(pattern, text)]
        assert len(fitting) <= MOST_MESSAGES, f"line {line}: '{pattern}' fits {fitting}"


def collected(source):
    return [text for _line, text in shown_texts.of_tree(ast.parse(source))]


def test_messages_are_found_wherever_they_are_said():
    assert collected('raise SceneError(f"\'{name}\' has no faces. Give it {count:,} of them")') == [
        "'…' has no faces. Give it … of them"
    ]
    assert collected('self.report({"ERROR"}, "Press " + button + " once more")') == ["Press … once more"]
    assert collected('note = f"{name} is {\'far away\' if far else \'near by\'}"') == ["far away", "near by"]
    assert collected('REFUSED = "It cannot use this: {}. Mend it"') == ["It cannot use this: …. Mend it"]
    assert collected('yield ("a long text " f"of {two} parts")') == ["a long text of … parts"]


def test_declarations_are_no_messages():
    assert collected('size: FloatProperty(name="Size", description="How far it reaches, at most")') == []
    assert collected('colour: aside(declare.ColorProperty)(description="Colour of the handle")') == []
    assert collected('bl_label = "Add Another Handle"') == []
    assert collected('ITEMS = [(\'OWN\', "Own Range", "From the first frame to the last")]') == []
    assert collected('def f():\n    """Returns what nobody is shown."""') == []
    assert collected('raise ValueError("rows of another shape")') == []


def test_an_entry_matches_by_the_fixed_parts():
    said = "Handle '…' has no control. Press Make Own Controls, or remove the handle"
    assert shown_texts.matches("Handle '…' has no control", said)
    assert shown_texts.matches("Handle … has no control. … remove the handle", said)
    assert not shown_texts.matches("has no control, Handle", said)
    assert not shown_texts.matches("Handle '…' has", said)  # too little to know it by
    assert not shown_texts.matches("Handle '…' has no bone", said)
    assert shown_texts.matches("Not bound (…)", "Not bound (…)")
    assert shown_texts.matches("Stale: the mesh has …", "the mesh has …")  # what is filled into another text


def test_strings_of_exceptions_in_cpp_are_joined():
    source = 'message("anchor ", k, " is vertex ", v, "; "\n    "numbered from 0")'
    assert shown_texts.cpp_text(source) == "anchor … is vertex …; numbered from 0"
    assert shown_texts.cpp_text('message(name, " has (", at(0), ") rows")') == "… has (…) rows"


def test_what_is_collected_is_not_little(texts):
    """The collector may not go blind."""
    native = sum(".cpp:" in each.where for each in texts)
    assert native > 50
    assert len(texts) - native > 400
