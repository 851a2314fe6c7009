# SPDX-License-Identifier: GPL-3.0-or-later
"""`./dev demo walk` at low resolution: by the operators from the generated C3D to baked meshes and pictures.

The figure of blended bones is what a well made rig would show: from 41 markers alone the mesh cannot be there to the
millimetre, and the distances are stated for that.
"""

import dataclasses

import bpy
import numpy as np
import pytest

from addon.capture.core import marker_sets
from blender_tests.demo import pictures, row
from blender_tests.demo.walk import capture, gait, measures, strip, subjects
from blender_tests.support import walking_figure

pytestmark = pytest.mark.slow

SPACING = 0.026  # 3,300 vertices
FRAMES = 70


@pytest.fixture
def carried(tmp_path):
    """make(subjects.walk) is the subject and what became of it."""

    def make(maker, **options):
        subject = maker(tmp_path, spacing=SPACING, **options)
        return subject, capture.carry(subject, tmp_path)

    return make


def test_the_walk_comes_near_the_skinned_figure(carried):
    subject, result = carried(subjects.walk, frames=FRAMES)
    height = subject.height
    assert result.shapes.shape == subject.truth.shape and len(result.anchors) == 41
    assert bpy.context.scene.render.fps == 100
    assert [modifier.type for modifier in bpy.data.objects["walk"].modifiers] == ['MESH_CACHE']
    assert np.nanmax(measures.misses(result)) < 0.01 * height
    assert measures.rms(result.shapes, subject.truth).max() < 0.02 * height
    assert measures.rms(measures.laid_on(result.shapes, subject.truth), subject.truth).max() < 0.012 * height
    assert measures.slide(result.shapes, subject.planted) < 0.01 * height
    assert measures.hover(result.shapes, subject.vertices, subject.planted) < 0.01
    assert measures.roughness(result.shapes).max() < 0.01 * height
    landmarks = marker_sets.recognise(result.names).landmarks
    truth = walking_figure.take(FRAMES).knee_angles
    for side in "LR":
        bent = gait.on_mesh(subject, result, landmarks, side)
        assert np.abs(bent - truth[side]).max() < 8.0
        skinned = gait.on_mesh(subject, dataclasses.replace(result, shapes=subject.truth), landmarks, side)
        assert np.abs(skinned - truth[side]).max() < 3.0, "the measure itself"
        measured = gait.in_capture(subject, result, landmarks, side)
        assert np.nanmax(np.abs(measured - truth[side])) < 6.0
    elbows = gait.elbows_off(subject, result, landmarks)
    assert len(elbows) == 2 * FRAMES and np.abs(elbows).max() < 8.0
    assert [what.split()[0] for what, _ in gait.rows(subject, result)] == ["slide", "knees", "elbows"]


def test_without_a_static_trial_soles_are_on_the_floor_too(tmp_path):
    subject = dataclasses.replace(subjects.walk(tmp_path, spacing=SPACING, frames=2 * FRAMES), standing=None)
    result = capture.carry(subject, tmp_path)
    assert measures.rms(measures.laid_on(result.shapes, subject.truth), subject.truth).max() < 0.025 * subject.height
    assert measures.hover(result.shapes, subject.vertices, subject.planted) < 0.01
    assert measures.slide(result.shapes, subject.planted) < 0.01 * subject.height


def test_shorter_legs_stand_still(carried):
    subject, result = carried(subjects.short_legs, frames=FRAMES)
    assert subject.height < 1.6
    assert measures.slide(result.shapes, subject.planted) < 0.01 * subject.height
    assert measures.hover(result.shapes, subject.vertices, subject.planted) < 0.01
    assert np.nanmax(measures.misses(result)) < 0.01 * subject.height


def test_sitting_down_ends_on_the_box(carried):
    subject, result = carried(subjects.sit, frames=200)
    top = subject.box[1][2]
    seated = result.shapes[180]
    over_box = (seated[:, 1] > subject.box[0][1] + 0.05) & (np.abs(seated[:, 0]) < 0.2)
    assert abs(seated[over_box, 2].min() - top) < 0.03
    assert measures.rms(result.shapes, subject.truth).max() < 0.02 * subject.height
    assert measures.slide(result.shapes, subject.planted) < 0.01 * subject.height


def test_the_strip_shows_figures_and_markers(carried, tmp_path):
    subject, result = carried(subjects.walk, frames=30)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    path = tmp_path / "strip.png"
    strip.draw(path, subject, result, [0, 10, 20], strip.SIDE, 'BLENDER_WORKBENCH', 1)
    pixels = pictures.read_png(path)
    assert pixels.shape[1] == row.WIDTH and (pixels[..., 3] == 1.0).all()
    red, green, blue = pixels[..., 0], pixels[..., 1], pixels[..., 2]
    is_marker = (red > 1.5 * green) & (green > 1.2 * blue)
    is_skin = (red > blue + 0.03) & ~is_marker
    assert 0.0005 < is_marker.mean() < 0.05
    assert all(third.mean() > 0.15 for third in np.array_split(is_skin.any(axis=0), 3)), "a figure is missing"
    assert 0.1 < is_skin.mean() < 0.7
