# SPDX-License-Identifier: GPL-3.0-or-later
"""PNG files as arrays: a backdrop behind a transparent render, and pictures side by side."""

import bpy
import numpy as np

BACKDROP_TOP = np.array([0.80, 0.85, 0.90])  # sRGB
BACKDROP_BOTTOM = np.array([0.97, 0.97, 0.96])


def read_png(path):
    """The picture as (height, width, 4) float32 sRGB, bottom row first."""
    image = bpy.data.images.load(str(path))
    image.alpha_mode = "STRAIGHT"
    width, height = image.size
    pixels = np.empty(width * height * 4, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)


def write_png(path, pixels):
    """Writes (height, width, 4) float32 sRGB, bottom row first."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("picture", width, height, alpha=True)
    image.pixels.foreach_set(np.ascontiguousarray(pixels, dtype=np.float32).ravel())
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    bpy.data.images.remove(image)


def over_backdrop(pixels):
    """The picture over a soft vertical gradient, opaque."""
    t = np.linspace(0.0, 1.0, pixels.shape[0])[:, None, None]
    backdrop = (1.0 - t) * BACKDROP_BOTTOM + t * BACKDROP_TOP
    alpha = pixels[:, :, 3:]
    result = np.ones_like(pixels)
    result[:, :, :3] = alpha * pixels[:, :, :3] + (1.0 - alpha) * backdrop
    return result


def side_by_side(shots):
    """Pictures of one height with white strips between them."""
    strip = np.ones((shots[0].shape[0], 8, 4), dtype=np.float32)
    return np.concatenate([part for shot in shots for part in (strip, shot)][1:], axis=1)
