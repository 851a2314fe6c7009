# SPDX-License-Identifier: GPL-3.0-or-later
"""scene/object_model.py, the one place that knows whether an object has changed, and what it depends on."""

import bpy
import pytest
from bpy.props import BoolProperty, CollectionProperty, FloatProperty, FloatVectorProperty, PointerProperty
from support import meshes, steps


@pytest.fixture
def declarations(part):
    return part("scene.declarations")


@pytest.fixture
def stamp(part):
    """stamp(obj): another one means that the object may be another by now."""
    model = part("posing.bridge.scene_input").model
    return lambda obj: model(obj).stamp(obj)


def other_value(group, name):
    """Another value than `group` has, for settings of any kind."""
    setting, value = group.bl_rna.properties[name], getattr(group, name)
    if setting.type == 'BOOLEAN':
        return not value
    if setting.type == 'ENUM':
        return next(item.identifier for item in setting.enum_items if item.identifier != value)
    if setting.type == 'STRING':
        return value + "x"
    return [0.25 + each for each in value] if getattr(setting, "is_array", False) else value + 0.25


def test_every_setting_counts_or_is_declared_aside(part, declarations, stamp):
    """Of all that is declared: a new setting counts without another edit."""
    obj = meshes.grid()
    steps.list_anchors(obj, A=[0, 4, 20])
    line = obj.meanvalue.handles["A"]
    aside = {"color", "rest_relation", "made_group", "made_control", "marker", "bone"}
    aside |= {"control_frame", "control_carried", "is_pin", "made_region", "cuff"}
    aside |= {"show_overlay", "former_result", "influence"}
    seen = set()
    for group in (obj.meanvalue, line):
        counted = declarations.names(type(group))
        for setting in group.bl_rna.properties:
            if setting.identifier not in type(group).__annotations__:  # Blender's own
                continue
            if setting.identifier in {"control", "live", "active_handle", "marker_number"}:
                continue
            if setting.type in {'COLLECTION', 'POINTER'}:
                continue
            before = stamp(obj)
            setattr(group, setting.identifier, other_value(group, setting.identifier))
            is_noticed = stamp(obj).signature != before.signature
            assert is_noticed == (setting.identifier in counted), setting.identifier
            assert is_noticed != (setting.identifier in aside), setting.identifier
            seen.add(setting.identifier)
    assert {"method", "rigidity", "roi_group", "is_soft", "strength", "follows", "is_enabled"} <= seen


def test_a_setting_that_nobody_knows_of_counts(declarations):
    class MEANVALUE_PG_inner(bpy.types.PropertyGroup):  # noqa: N801  Blender's way
        place: FloatVectorProperty(size=3)
        note: declarations.aside(BoolProperty)()

    class MEANVALUE_PG_dummy(bpy.types.PropertyGroup):  # noqa: N801
        strength: FloatProperty()
        color: declarations.aside(FloatProperty)()
        parts: CollectionProperty(type=MEANVALUE_PG_inner)
        inner: PointerProperty(type=MEANVALUE_PG_inner)
        other: PointerProperty(type=bpy.types.Object)

    classes = (MEANVALUE_PG_inner, MEANVALUE_PG_dummy)
    for cls in classes:
        bpy.utils.register_class(cls)
    bpy.types.Object.meanvalue_dummy = PointerProperty(type=MEANVALUE_PG_dummy)
    try:
        obj = meshes.grid()
        dummy = obj.meanvalue_dummy
        said = [declarations.values(dummy)]

        def note():
            said.append(declarations.values(dummy))
            return said[-1] != said[-2]

        assert not note()
        dummy.strength = 2.0
        assert note()
        dummy.color = 2.0
        assert not note()
        dummy.parts.add()
        assert note()
        dummy.parts[0].place[1] = 3.0
        assert note()
        dummy.parts[0].note = True
        assert not note()
        dummy.inner.place[0] = 1.0
        assert note()
        dummy.other = obj
        assert note()
    finally:
        del bpy.types.Object.meanvalue_dummy
        for cls in reversed(classes):
            bpy.utils.unregister_class(cls)


def test_numbers_of_revisions_never_come_back(part, stamp):
    """What somebody remembers from before undo must not fit afterwards."""
    obj = meshes.grid()
    before = stamp(obj)
    part("scene.object_model").clear()
    assert stamp(obj).content != before.content


def test_asking_changes_nothing(stamp):
    obj = meshes.grid()
    obj.meanvalue.rigidity += 1.0
    assert stamp(obj) == stamp(obj)
