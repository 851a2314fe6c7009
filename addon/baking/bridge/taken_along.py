# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of what goes along with the mesh: each has a point cache or shape keys of its own, made of the mesh's rows."""

import types

import bpy
import numpy as np

from ...compat import session_key
from ...errors import SceneError
from ...scene import along, worn
from ...scene.core.whole_files import file_name
from ...solver.core.fingerprint import digest
from ..core import point_cache
from . import playing, preparing


class TakenAlong:
    """Of one bake; obj is the mesh, options as of a Baking."""

    def __init__(self, obj, times, options):
        """@throws SceneError, CacheError where something cannot be baked so; nothing was changed then."""
        self._paths, self._made = {}, {}  # by session key: (as the modifier shows it, in full); [n x 3] for keys
        homes = {str(preparing.paths(obj, options)[1]).casefold(): obj}
        for _line, other in worn.taken(obj):
            stem, name = options.path.strip().removesuffix(".pc2"), file_name(bpy.path.clean_name(other.name))
            own = types.SimpleNamespace(**{**vars(options), "path": stem and f"{stem}_{name}.pc2"})
            shown, path = self._paths[session_key(other)] = preparing.paths(other, own)
            first = homes.setdefault(str(path).casefold(), other)
            if shown and first != other:
                raise SceneError(f"'{first.name}' and '{other.name}' would be baked to one file. Rename one of them")
            preparing.require_fit(other, times, own, path)

    def _followers(self, obj):  # of what it began with: others may go along since
        return along.followers(obj, [each for each in worn.taken(obj) if session_key(each[1]) in self._paths])

    def choose(self, obj, shapes):
        """For keys, of [n x 3] of the mesh: generator of the share done. @throws MeanValueError."""
        for number, shape in enumerate(shapes):
            for follower, others in self._followers(obj):
                for other, found in zip(others, follower.follow(shape), strict=True):
                    self._made.setdefault(session_key(other), []).append(found)
            yield number / len(shapes)
        self._made = {key: made for key, made in self._made.items() if len(made) == len(shapes)}

    def write(self, obj, rows, plan):
        """The point caches, of those of the mesh: generator of the share done. @throws MeanValueError."""
        for follower, others in self._followers(obj):
            key = digest(plan.key, *follower.key, *follower.places)
            homes = [(self._paths[session_key(one)][1], key, plan.header_of(len(one.data.vertices))) for one in others]
            self._made.update({session_key(each): [] for each in others})
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
        for other in (each for each in along.group(obj)[1:] if session_key(each) in self._made):
            playing.take_back(other)
            if self._made[session_key(other)]:
                notes += playing.play_keys(other, times, self._made[session_key(other)])
            else:
                playing.play_cache(other, self._paths[session_key(other)][0], plan.header_of(len(other.data.vertices)))
        return notes


def baked(obj):
    """The mesh, and what else a bake of it plays in: what has handles has a bake of its own."""
    return [obj, *(each for _, each in worn.listed(obj) if each.meanvalue.baked.target and not each.meanvalue.handles)]
