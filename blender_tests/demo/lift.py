# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo lift`, and its report."""

import time

import bpy
import numpy as np
from PIL import Image

from . import built_in, creature, markers, photograph, pose, stage

ABOUT = ("an animated octopus",)
DESCRIPTION = """\
The octopus lifts a tentacle by one anchor vertex, up and down, solved by the add-on's operators at each step: an
animated picture."""
OPTIONS = {"flags": {"--listing": "only the pictures of the extension's listing"}}

STEPS = 13
SECONDS = 0.08
WIDTH, HEIGHT = 480, 320
#: Pictures of the extension's listing, in the sizes that Blender's platform asks for.
FEATURED, ICON = (1920, 1080), (256, 256)


def blocks(words, empty_scene):
    """The report's lines; makes the picture."""
    empty_scene()
    model = creature.build_creature()
    lift = built_in.Lift(model)
    subject = built_in.octopus(model)
    began = time.perf_counter()
    pose.pose_by_operators(subject)
    places = solve_steps(subject.obj, lift)
    seconds = time.perf_counter() - began
    if words.listing:
        return [draw_listing(subject, places, words)]
    path = words.output / "octopus_lift.webp"
    frames = draw(subject, lift, places, words)
    save_animated(path, [*frames, *frames[-2:0:-1]])
    return [
        [
            f"steps solved:  {STEPS}, in {seconds:.1f} s with binding",
            f"lift:          0 to {built_in.LIFT_ANGLE_DEG:.0f} degrees",
            f"picture:       {path.name}, {path.stat().st_size / 1e6:.2f} MB",
        ]
    ]


def draw_listing(subject, places, words):
    """Lines of the report; renders the mesh at the last of the places."""
    pose.result_key(subject.obj).data.foreach_set("co", places[-1].astype(np.float32).ravel())
    photograph.show_pose(subject.obj, 1.0)
    picture = stage.Picture(*FEATURED, words.samples, words.engine)
    stage.set_stage(places[-1], picture, subject.view.azimuth_deg, subject.view.elevation_deg)
    path = words.output / "listing_featured.png"
    stage.render(path)
    # Of the icon the middle, as high as the picture.
    left, height = (FEATURED[0] - FEATURED[1]) // 2, FEATURED[1]
    icon = Image.open(path).crop((left, 0, left + height, height)).resize(ICON)
    icon.save(words.output / "listing_icon.png")
    return [f"pictures:      {path.name}, listing_icon.png"]


def save_animated(path, frames):
    """An animated picture of frames (height, width, 3) uint8."""
    first, *others = [Image.fromarray(frame) for frame in frames]
    first.save(path, save_all=True, append_images=others, duration=round(1000 * SECONDS), loop=0, quality=75)


def solve_steps(obj, lift):
    """[(n, 3) world positions] of each step of the way up, eased at both ends."""
    keys = obj.data.shape_keys.key_blocks
    pose_key = obj.active_shape_key
    rest = pose.positions(obj)
    places = []
    for share in 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, STEPS)):
        goal = rest.copy()
        # At rest nothing would be posed, and Solve would say so.
        goal[lift.anchor] = lift.target(max(share, 0.01) * built_in.LIFT_ANGLE_DEG)
        obj.active_shape_key_index = keys.find(pose_key.name)
        pose_key.data.foreach_set("co", goal.astype(np.float32).ravel())
        obj.data.update_tag()
        pose.call(bpy.ops.meanvalue.solve_from_key)
        places.append(photograph.posed_points(obj, 1.0))
    return places


def draw(subject, lift, places, words):
    """[(HEIGHT, WIDTH, 3) uint8, top row first]: the mesh at each of the places, and the anchor."""
    obj = subject.obj
    everything = np.concatenate([places[0], places[-1]])
    picture = stage.Picture(WIDTH, HEIGHT, words.samples, words.engine)
    stage.set_stage(everything, picture, subject.view.azimuth_deg, subject.view.elevation_deg)
    diagonal = float(np.linalg.norm(np.ptp(everything, axis=0)))
    shown, frames = pose.result_key(obj), []
    path = words.output / "octopus_lift_frame.png"
    for place in places:
        shown.data.foreach_set("co", place.astype(np.float32).ravel())
        photograph.show_pose(obj, 1.0)
        mark = markers.add_anchor_spheres("Anchor", place[[lift.anchor]], 1.5 * diagonal)
        bpy.context.view_layer.update()
        pixels = stage.render(path)[::-1, :, :3]
        frames.append((255.0 * pixels.clip(0.0, 1.0)).round().astype(np.uint8))
        bpy.data.objects.remove(mark)
    path.unlink()
    return frames
