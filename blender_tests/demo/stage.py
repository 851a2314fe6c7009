# SPDX-License-Identifier: GPL-3.0-or-later
"""The studio: one camera fitted to every pose, soft key, rim and fill light, a ground that takes shadow."""

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix

from . import pictures

LENS_MM, SENSOR_MM = 70.0, 36.0
# Direction towards each light in the camera's frame (right, up, backwards), distance, side length (both over
# the subject's radius), and irradiance weight.
LIGHTS = {
    "Key": ((-0.80, 1.25, 0.55), 4.0, 1.7, 1.5),
    "Rim": ((0.60, 0.85, -0.85), 4.5, 1.8, 0.8),
}
LIGHT_POWER = 52.0  # watts for a subject of radius 1 at weight 1
WORLD_STRENGTH = 0.30  # the fill light: an even sky is less noisy than a third lamp


@dataclass(frozen=True)
class Picture:
    """Size in pixels, Cycles samples per pixel, and the render engine: CYCLES or BLENDER_WORKBENCH."""

    width: int = 960
    height: int = 720
    samples: int = 32
    engine: str = "CYCLES"


def camera_axes(azimuth_deg, elevation_deg):
    """Unit axes (3, 3) of a camera looking at the origin: right, up, backwards.

    azimuth 0 looks from -y, positive turns the camera towards +x; elevation is above the horizon.
    """
    azimuth, elevation = np.radians(azimuth_deg), np.radians(elevation_deg)
    backwards = np.array([np.sin(azimuth) * np.cos(elevation), -np.cos(azimuth) * np.cos(elevation), np.sin(elevation)])
    right = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    return np.stack([right, np.cross(backwards, right), backwards])


def fitted_camera_position(points, axes, aspect, margin):
    """Where a perspective camera of fixed direction must stand to see all `points` (n, 3), centred.

    aspect: width over height; margin: part of the frame left free on each side. Returns (3,).
    Each frame edge is a half space per point; the tightest pair per direction fixes the camera (no search).
    """
    half_width = SENSOR_MM / 2.0 / LENS_MM * (1.0 - 2.0 * margin)
    local = points @ axes.T
    depth = -local[:, 2]
    position = np.zeros(3)
    forward = np.inf
    for axis, slope in ((0, half_width), (1, half_width / aspect)):
        high, low = np.max(local[:, axis] - slope * depth), np.max(-local[:, axis] - slope * depth)
        position[axis] = 0.5 * (high - low)
        forward = min(forward, -(high + low) / (2.0 * slope))
    position[2] = -forward
    return position @ axes


def set_stage(points, picture, azimuth_deg=0.0, elevation_deg=20.0, margin=0.07):
    """Adds camera, lights, world and ground for a subject that covers `points` (n, 3) over all its poses."""
    scene = bpy.context.scene
    axes = camera_axes(azimuth_deg, elevation_deg)
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    radius = 0.5 * float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))

    camera_data = bpy.data.cameras.new("Camera")
    camera_data.lens, camera_data.sensor_width, camera_data.sensor_fit = LENS_MM, SENSOR_MM, "HORIZONTAL"
    camera_data.clip_start, camera_data.clip_end = 0.01 * radius, 100.0 * radius
    position = fitted_camera_position(points, axes, picture.width / picture.height, margin)
    scene.camera = add_placed("Camera", camera_data, position, axes)

    for name, (direction, distance, size, weight) in LIGHTS.items():
        backwards = np.array(direction) @ axes
        backwards /= np.linalg.norm(backwards)
        light = bpy.data.lights.new(name, "AREA")
        light.shape, light.size = "DISK", size * radius
        light.energy = LIGHT_POWER * weight * distance**2 / 10.0 * radius**2
        right = np.cross([0.0, 0.0, 1.0], backwards)
        right /= np.linalg.norm(right)
        light_axes = np.stack([right, np.cross(backwards, right), backwards])
        add_placed(name, light, centre + distance * radius * backwards, light_axes)

    set_world()
    if picture.engine == "CYCLES":  # Workbench would draw the shadow catcher as a grey floor
        add_ground(centre, float(points[:, 2].min()), 20.0 * radius)
    set_render(picture)


def add_placed(name, data, position, axes):
    """Links an object for `data` at `position` with its local x, y, z along the rows of `axes`."""
    obj = bpy.data.objects.new(name, data)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.asarray(axes).T, position
    obj.matrix_world = Matrix(matrix.tolist())
    bpy.context.scene.collection.objects.link(obj)
    return obj


def set_world():
    """An even pale sky: fills the shadows without a picture of its own."""
    world = bpy.data.worlds.new("Studio")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.85, 0.92, 1.0, 1.0)
    background.inputs["Strength"].default_value = WORLD_STRENGTH
    bpy.context.scene.world = world


def add_ground(centre, height, half_size):
    """A plane that shows only the shadows that fall on it."""
    mesh = bpy.data.meshes.new("Ground")
    signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    corners = [(centre[0] + x * half_size, centre[1] + y * half_size, height) for x, y in signs]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    ground = bpy.data.objects.new("Ground", mesh)
    ground.is_shadow_catcher = True
    bpy.context.scene.collection.objects.link(ground)


def set_render(picture):
    """Engine, size and colour settings that look the same in every Blender version."""
    scene = bpy.context.scene
    scene.render.engine = picture.engine
    scene.render.resolution_x, scene.render.resolution_y = picture.width, picture.height
    scene.render.resolution_percentage = 100
    scene.render.film_transparent = True
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGBA"
    scene.view_settings.view_transform = "Standard"  # Filmic and AgX differ between versions
    shading = scene.display.shading  # Workbench's
    shading.light, shading.show_cavity = "STUDIO", True
    nodes = [node for each in bpy.data.materials if each.use_nodes for node in each.node_tree.nodes]
    shading.color_type = "TEXTURE" if any(node.type == 'TEX_IMAGE' for node in nodes) else "MATERIAL"
    scene.cycles.device = "CPU"
    scene.cycles.samples = picture.samples
    scene.cycles.use_denoising = False  # Debian's Blender has no denoiser
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.seed = 1
    scene.cycles.max_bounces = 3


def render(path):
    """Renders the scene over a backdrop to a PNG; returns it as (height, width, 4) float32 sRGB, bottom row first."""
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    shot = pictures.over_backdrop(pictures.read_png(path))
    pictures.write_png(path, shot)
    return shot
