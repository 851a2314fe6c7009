# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of what goes along with the mesh: each has a point cache or shape keys of its own, made of the mesh's rows."""

import types

import bpy
import numpy as np

from ...scene import along, worn
from ...scene.core.whole_files import file_name
from ...solver.core.fingerprint import digest
from ..core import point_cache
from . import playing, preparing


class TakenAlong:
    """Of one bake; obj is the mesh, options as of a Baking."""

    def __init__(self, obj, times, options):
        """@throws SceneError, CacheError where something cannot be baked so; nothing was changed then."""
        self._paths, self._made = {}, {}  # by name: (as the modifier shows it, in full); [n x 3] for keys, or none
        for _line, other in worn.taken(obj):
            stem, name = options.path.strip().removesuffix(".pc2"), file_name(bpy.path.clean_name(other.name))
            own = types.SimpleNamespace(**{**vars(options), "path": stem and f"{stem}_{name}.pc2"})
            self._paths[other.name] = preparing.paths(other, own)
            preparing.require_fit(other, times, own, self._paths[other.name][1])

    def choose(self, obj, shapes):
        """For keys, of [n x 3] of the mesh: generator of the share done. @throws MeanValueError."""
        for number, shape in enumerate(shapes):
            for follower, others in along.followers(obj):
                for other, found in zip(others, follower.follow(shape), strict=True):
                    self._made.setdefault(other.name, []).append(found)
            yield number / len(shapes)

    def write(self, obj, rows, plan):
        """The point caches, of those of the mesh: generator of the share done. @throws MeanValueError."""
        for follower, others in along.followers(obj):
            key = digest(plan.key, *follower.key, *follower.places)
            homes = [(self._paths[other.name][1], key, plan.header_of(len(other.data.vertices))) for other in others]
            self._made.update({other.name: [] for other in others})
            if all(point_cache.is_current(*home) for home in homes):
                continue
            caches = [point_cache.Begun(*home) for home in homes]
            for begin, end in plan.chunks():
                shapes = []
                for row in rows[begin:end]:
                    shapes.append(follower.follow(np.array(row)))
                    yield (begin + len(shapes)) / len(rows)
                for cache, found in zip(caches, zip(*shapes, strict=True), strict=True):
                    cache.write(begin, np.array(found), [""] * (end - begin))
            for cache, other, home in zip(caches, others, homes, strict=True):
                cache.become_whole()
                preparing.write_marker(home[0], other, key)

    def play(self, obj, plan, times):
        """times: of the shapes that were chosen. Returns notes."""
        notes = along.problems(obj)
        for other in (each for each in along.group(obj)[1:] if each.name in self._made):
            playing.take_back(other)
            if self._made[other.name]:
                notes += playing.play_keys(other, times, self._made[other.name])
            else:
                playing.play_cache(other, self._paths[other.name][0], plan.header_of(len(other.data.vertices)))
        return notes


def baked(obj):
    """The mesh, and what else a bake of it plays in."""
    return [obj, *(other for _, other in worn.listed(obj) if other.meanvalue.baked.target)]
