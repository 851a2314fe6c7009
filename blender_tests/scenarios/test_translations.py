# SPDX-License-Identifier: GPL-3.0-or-later
"""Other languages, by Blender's own translation. What the files have to hold is checked on the host."""

import sys

import bpy
import pytest
from support import installed, meshes, steps

MODULE = installed.PACKAGE
#: A button and a message that Blender's own catalogue does not know, in German.
BUTTON, GERMAN_BUTTON = "Add Handle", "Neuer Griff"
#: Blender's French says so, too.
UNTRANSLATED = {"Frame"}
LANGUAGES = {"de": "de_DE", "fr": "fr_FR", "ja": "ja_JP", "zh_HANS": "zh_CN"}


def shown(text, context="Operator"):
    return bpy.app.translations.pgettext_iface(text, context)


@pytest.fixture
def speak():
    """speak("de") sets the language of the interface; skips where this Blender has none."""
    view = bpy.context.preferences.view

    def choose(language):
        codes = {language, f"{language}_{language.upper()}", LANGUAGES[language]}
        known = sorted(codes & set(bpy.app.translations.locales))
        if not known:
            pytest.skip(f"this Blender does not speak {language}")
        view.language = known[0]
        view.use_translate_interface = view.use_translate_tooltips = True

    before = view.language
    yield choose
    view.language = before


@pytest.mark.parametrize("language", LANGUAGES)
def test_buttons_are_in_the_language_of_the_interface(part, speak, language):
    speak(language)
    translations = part("translations")
    wanted = translations.read(translations.FOLDER / f"{language}.po")
    other = [
        (context, english)
        for (context, english), text in wanted.items()
        if shown(english, context) in {english, ""} and text != english and english not in UNTRANSLATED
    ]
    assert other == []
    # Where Blender's catalogue has the same words, its own come first.
    own = sum(shown(english, context) == text for (context, english), text in wanted.items())
    assert own > 0.85 * len(wanted)


def test_messages_are_in_the_language_of_the_interface(part, speak):
    obj = steps.bound_grid(meshes.grid())
    status = part("bridge.object_status")
    assert status.status(obj).text.startswith("Bound: 25 vertices, 4 held")
    speak("de")
    status.clear()
    assert status.status(obj).text.startswith("Gebunden: 25 Vertices, 4 gehalten")
    assert part("core.wording").stage("solve") == "Pose wird gesucht"
    bpy.ops.meanvalue.unbind()
    with pytest.raises(RuntimeError, match="noch nicht gebunden"):
        bpy.ops.meanvalue.solve()


def test_off_and_on_again(speak):
    speak("de")
    addon = sys.modules[MODULE]
    assert shown(BUTTON) == GERMAN_BUTTON
    bpy.ops.preferences.addon_disable(module=MODULE)
    assert shown(BUTTON) == BUTTON
    bpy.ops.preferences.addon_enable(module=MODULE)
    assert shown(BUTTON) == GERMAN_BUTTON
    for _ in range(3):
        addon.unregister()
        addon.register()
    assert shown(BUTTON) == GERMAN_BUTTON


def test_a_registering_that_was_broken_off_is_no_hindrance(part, speak):
    speak("de")
    part("translations").register()
    part("translations").register()
    assert shown(BUTTON) == GERMAN_BUTTON


def test_all_that_blender_knows_of_is_in_the_files(part):
    """As the host test, from the other side: names and tooltips of what is registered."""
    translations = part("translations")
    wanted = translations.read(translations.FOLDER / "de.po")
    names = {"", "Mean-Value", "Mean-Value Grab", *part("core.capture.readers").UP_AXES}
    for kind in part("registration").CLASSES:
        if not issubclass(kind, bpy.types.Operator | bpy.types.Panel | bpy.types.Menu):
            continue
        context = getattr(kind, "bl_translation_context", None) or kind.bl_rna.translation_context
        if issubclass(kind, part("ui.presets").PresetPanel):
            continue  # Blender has the name of the last preset there
        assert kind.bl_label in names or (context, kind.bl_label) in wanted, kind
        told = kind.bl_rna.description
        if issubclass(kind, bpy.types.Operator):
            rna = getattr(bpy.ops.meanvalue, kind.bl_idname.split(".")[1]).get_rna_type()
            told = rna.description
            for prop in rna.properties:
                is_shown = not prop.is_hidden and prop.identifier not in OF_BLENDER
                assert not is_shown or in_files(prop, wanted, names), (kind, prop.identifier)
        assert told in names or ("*", told) in wanted, kind
    for kind in (part("properties").MEANVALUE_PG_settings, part("properties_handles").MEANVALUE_PG_anchor_group):
        for prop in kind.bl_rna.properties:
            declared = kind.__annotations__.get(prop.identifier)
            # Without a name in the declaration, Blender makes one of the identifier: it is shown nowhere.
            is_shown = declared is not None and "name" in declared.keywords and not prop.is_hidden
            assert prop.identifier in OF_BLENDER or not is_shown or in_files(prop, wanted, names), prop


#: Properties that Blender's own mix-ins (for files and presets) bring along, with their words.
OF_BLENDER = {
    "rna_type", "filepath", "files", "directory", "filter_glob", "check_existing", "hide_props_region", "name",
    "remove_name", "remove_active", "filter_folder",
}


def in_files(prop, wanted, names):
    items = prop.enum_items if prop.type == 'ENUM' else ()
    texts = [prop.name, prop.description, *(text for item in items for text in (item.name, item.description))]
    return all(text in names or ("*", text) in wanted for text in texts)
