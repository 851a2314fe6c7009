# SPDX-License-Identifier: GPL-3.0-or-later
"""sliders/bridge/key_shapes.py: which keys may be driven, and what they do, as Blender itself shows it."""

import numpy as np
import pytest
from support import meshes, steps


@pytest.fixture
def key_shapes(part):
    return part("sliders.bridge.key_shapes")


def add_key(obj, name, seed=0, relative="Basis"):
    rng = np.random.default_rng(seed)
    key = obj.shape_key_add(name=name, from_mix=False)
    key.relative_key = obj.data.shape_keys.key_blocks[relative]
    key.data.foreach_set("co", rng.normal(size=3 * len(obj.data.vertices)).astype(np.float32))
    key.value = 0.0
    return key


@pytest.fixture
def obj():
    obj = meshes.grid()
    obj.shape_key_add(name="Basis")
    return obj


def test_shapes_are_those_that_blender_shows(obj, key_shapes):
    add_key(obj, "Plain", 1)
    chained = add_key(obj, "Chained", 2, relative="Plain")
    steps.add_weights(obj, "Part", np.linspace(0.0, 1.0, 25))
    chained.vertex_group = "Part"
    chained.slider_min, chained.slider_max = -1.0, 2.0
    found = key_shapes.gather(obj)
    assert found.names == ("Plain", "Chained")
    assert found.lower.tolist() == [0.0, -1.0]
    assert found.upper.tolist() == [1.0, 2.0]
    key_shapes.set_values(obj, found.names, [0.25, 1.5])
    np.testing.assert_allclose(meshes.seen(obj), found.mixed(key_shapes.values(obj, found.names)), atol=1e-5)


def test_what_is_not_ours_to_move_is_left_alone_and_said_so(obj, key_shapes):
    add_key(obj, "Free", 1)
    add_key(obj, "Muted", 2).mute = True
    add_key(obj, "Driven", 3).driver_add("value")
    copy = add_key(obj, "Copy")
    copy.data.foreach_set("co", steps.key_positions(obj, "Basis").ravel())
    obj.meanvalue.result_key = add_key(obj, "Result", 5).name
    locked = hasattr(copy, "lock_shape")
    if locked:
        add_key(obj, "Locked", 6).lock_shape = True
    found = key_shapes.gather(obj)
    assert found.names == ("Free",)
    assert dict(found.left_alone) == {
        "Muted": "muted",
        "Driven": "moved by a driver",
        "Copy": "without effect",
        **({"Locked": "locked"} if locked else {}),
    }


def test_nothing_to_drive_is_told(obj, key_shapes, part):
    error = part("errors").SceneError
    with pytest.raises(error, match="has no shape keys to drive"):
        key_shapes.gather(obj)
    add_key(obj, "Muted", 1).mute = True
    assert "can be driven: 'Muted' (muted) is left alone" in key_shapes.problem(obj)
    copy = add_key(obj, "Copy")
    copy.data.foreach_set("co", steps.key_positions(obj, "Basis").ravel())
    assert key_shapes.problem(obj) is None
    with pytest.raises(error, match="without effect"):
        key_shapes.gather(obj)
    obj.data.shape_keys.use_relative = False
    with pytest.raises(error, match="absolute"):
        key_shapes.gather(obj)


def test_values_are_keyed_on_the_current_frame(obj, key_shapes, part):
    add_key(obj, "Free", 1)
    key_shapes.set_values(obj, ["Free"], [0.5])
    obj.meanvalue.drive = 'SHAPE_KEYS'
    assert part("sliders.bridge.driven_keys").keyframe(obj) == (1, "shape key")
    path = 'key_blocks["Free"].value'
    frames, values = part("scene.actions").read_keys(obj.data.shape_keys, path)
    assert (frames.tolist(), values.tolist()) == ([1.0], [0.5])
