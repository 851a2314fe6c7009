# SPDX-License-Identifier: GPL-3.0-or-later
"""What the Grab tool holds: a new handle with its surroundings, or one that is there; and the way back."""

import bpy
import numpy as np
from mathutils import Quaternion, Vector

from ...errors import SceneError, require_none
from ...live import engine, roll
from ...scene import along, declarations, kept, rig_space, shape_keys, vertex_groups
from ..core import bind_input
from . import control_places, controls, new_handles, region, targets

#: Sizes closer than this are the same one.
SAME_SIZE = 1e-6

#: Of how a shape key is shown, what making and muting the result changes; the limits of the slider before the value,
#: which they cut off.
KEY_STATE = ("mute", "vertex_group", "slider_min", "slider_max", "value")

#: What places a control.
CHANNELS = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")

#: Settings that making a handle and its region changes.
SETTINGS = ("active_handle", "live", "roi_group", "made_region", "result_name", "result_mark")

#: The end of a limb is where its region's weights are no higher.
END_OF_LIMB = 0.25

#: A handle turns with its limb if that ends so far away on the average, as shares of the surroundings' reach: not at
#: all up to the first, as in the middle of a surface, where it ends all around; wholly from the second on.
LEAST_LIMB, WHOLE_LIMB = 0.4, 0.7


class Grip:
    """Holds no datablock: names and arrays alone. All places are in the object's own space if not said otherwise.

    handle_name  of the handle that is held
    is_new       it was made for this grip
    has_size     whether resize() does anything
    """

    def __init__(self, obj, vertex, size, name=""):
        """Takes the handle `name`, or the one that has `vertex`, or makes one.

        @throws SceneError before anything is changed.

        size: how far the surroundings of a new handle follow, as a share of the mesh's size.
        """
        self._before = _Before(obj)
        index = obj.meanvalue.handles.find(name)
        index = new_handles.handle_at(obj, vertex) if index < 0 else index
        self.is_new = index is None
        _require_can_be_posed(obj)
        if self.is_new:
            if not (kept.faces(obj.data)[0] == vertex).any():
                raise SceneError(f"'{obj.name}' has no face at this vertex, so nothing can follow it. Press on a face")
            rig_space.measure(obj)  # throws before anything is changed
            vertices = new_handles.near_vertices(obj, vertex, size)
            is_first = all(handle.follows == 'REST' or not handle.is_enabled for handle in obj.meanvalue.handles)
            self.has_size = bool(obj.meanvalue.roi_group) or is_first
            if self.has_size:
                self._before.region_weights(obj)
        else:
            _require_control(obj, obj.meanvalue.handles[index])
            obj.meanvalue.active_handle = index
            self.has_size = bool(obj.meanvalue.roi_group)
        self._rest_of_region = self._limb = self._around = None
        with engine.held(), kept.writing(obj):
            handle = new_handles.add_handle(obj, vertices) if self.is_new else obj.meanvalue.handles[index]
            self.handle_name, self._size_before = handle.name, handle.size
            if self.is_new:
                controls.add_control(obj, handle, vertices)
            if not obj.meanvalue.live:  # before the region is written: to Blender any setting is an edit of the mesh
                obj.meanvalue.live = True
            if self.is_new:
                self.resize(obj, size)
        self._start, made = control_places.world_of(handle), handle.control
        if self.is_new:  # Blender may not have evaluated it yet
            self._start = np.array(obj.matrix_world @ made.matrix_parent_inverse @ made.matrix_basis)
        self._seen = rig_space.shown_positions(obj)
        self._pivot = self._start[:3, 3]
        if vertex >= 0:
            self._pivot = np.array(obj.matrix_world @ Vector(self._seen[vertex].tolist()))
        # Of a matrix alone, scales would come back with other signs.
        mover = controls.mover(self.handle(obj))
        self._channels = {name: tuple(getattr(mover, name)) for name in CHANNELS}

    def handle(self, obj):
        """@throws SceneError if it is gone."""
        if self.handle_name not in obj.meanvalue.handles:
            raise SceneError(f"Handle '{self.handle_name}' is gone")
        return obj.meanvalue.handles[self.handle_name]

    def resize(self, obj, size):
        """Has as much follow as `size` says, besides what the region has of others. Returns whether it did not yet."""
        handle = self.handle(obj)
        if not self.has_size or abs(size - handle.size) < SAME_SIZE:
            return False
        if self._rest_of_region is None:
            before = self._before.region_weights(obj)
            self._rest_of_region = before if self.is_new else region.without(obj, handle, before)
        handle.size, self._limb = size, None
        self._around = region.around(obj, handle)
        region.write(obj, np.maximum(self._rest_of_region, self._around))
        return True

    def move(self, obj, offset):
        """Puts the control so far (3, world) from where it was when it was gripped, turned as the limb is that it is
        the end of. It is back when the mouse is, since nothing but `offset` says how far it turns."""
        if self._limb is None:
            self._limb = self._find_limb(obj)
        way, share = self._limb
        turn = way.rotation_difference(way + Vector(offset)) if share > 0.0 else Quaternion()
        matrix = np.array(Quaternion().slerp(turn, share).to_matrix())
        world = self._start.copy()
        world[:3, :3] = matrix @ world[:3, :3]
        world[:3, 3] = self._pivot + offset + matrix @ (world[:3, 3] - self._pivot)
        control_places.put(self.handle(obj), world)

    def _find_limb(self, obj):
        """(from where its surroundings end to the handle, 3 in the world; how much it turns with that, 0 to 1)."""
        handle = self.handle(obj)
        weights = region.around(obj, handle) if self._around is None else self._around
        some = np.flatnonzero((weights > 0.0) & (weights <= END_OF_LIMB))
        if len(some) == 0:
            return Vector(), 0.0
        end = np.average(self._seen[some], axis=0, weights=weights[some])
        way = Vector(self._pivot) - obj.matrix_world @ Vector(end.tolist())
        reach = region.radius(obj, handle.size) * max(map(abs, obj.matrix_world.to_scale()))
        return way, float(np.clip((way.length / reach - LEAST_LIMB) / (WHOLE_LIMB - LEAST_LIMB), 0.0, 1.0))

    def has_moved(self, obj, offset):
        """Whether the control went along when it was moved by (3, world), as the scene has it."""
        bpy.context.view_layer.update()
        way = control_places.world_of(self.handle(obj))[:3, 3] - self._start[:3, 3]
        return np.linalg.norm(way) > 0.5 * np.linalg.norm(offset)

    def hold_back(self, obj, bind_input):
        """Puts the control back to where its limb reaches, if it is farther away. Returns [sentence]."""
        handle, space = self.handle(obj), rig_space.measure(obj)
        placed = targets.positions(obj, bind_input, space)
        held, names = targets.within_reach(obj, bind_input, placed)
        if handle.name in names:
            members = bind_input.handles == targets.enabled_handles(obj).index(handle)
            transform = control_places.rig_transform(space, handle, bind_input.anchors[members])
            world = control_places.world_of(handle)
            world[:3, 3] += (np.array(obj.matrix_world) @ transform)[:3, :3] @ (held - placed)[members][0]
            control_places.put(handle, world)
        return targets.held_back_notes(names)

    def take_back(self, obj):
        """As it was before."""
        if self.is_new:
            self._before.bring_back(obj, self.handle_name)
            return
        handle = self.handle(obj)
        handle.size = self._size_before
        mover = controls.mover(handle)
        for channel, value in self._channels.items():
            setattr(mover, channel, value)
        self._before.bring_back(obj, "")

    def notes(self, obj):
        if self.is_new and not self.has_size:
            yield "No region is set, so all that is not held follows. Press Grow Region from Handle to have less follow"
        for kind in self._before.others:
            yield f"{kind.LABEL} was turned off: handles and it take turns"


class _Before:
    """What a grip changes beside the handle's control."""

    def __init__(self, obj):
        settings = obj.meanvalue
        self._settings = {name: getattr(settings, name) for name in SETTINGS}
        self.others = [] if settings.live else roll.kinds_on(obj)
        self._had_along = bool(settings.along)
        self._had_group = settings.roi_group in obj.vertex_groups
        self._was_bound = settings.bound.is_bound
        self._weights = None
        self._result = shape_keys.result_positions(obj)
        key = shape_keys.result(obj)
        self._relative_to = key and key.relative_key.name
        self._shown = key and [getattr(key, name) for name in KEY_STATE]
        self._active_group = vertex_groups.active_name(obj)

    def region_weights(self, obj):
        if self._weights is None:  # asked for before anything is written
            self._weights = region.weights(obj)
        return self._weights

    def bring_back(self, obj, made_handle):
        settings = obj.meanvalue
        if made_handle in settings.handles:
            controls.remove_handle(obj, settings.handles.find(made_handle))
        region_name = self._settings["roi_group"]
        if self._weights is not None and self._had_group and settings.roi_group == region_name:
            vertex_groups.replace_weights(obj, obj.vertex_groups[region_name], self._weights)
        elif self._weights is not None:
            region.remove_made_group(obj)
        if self._result is None:
            along.remove_pose(*along.group(obj))
        if not self._had_along:
            along.release(obj)
        for name, value in self._settings.items():
            setattr(settings, name, value)
        if self._result is not None:
            shape_keys.write_positions(obj.data, shape_keys.result(obj), self._result)
            along.pose(obj, self._result)
        if not self._was_bound:
            declarations.clear(settings.bound)
        for kind in self.others:
            kind.turn(obj, True)
        key = shape_keys.result(obj)
        if key and self._shown:
            key.relative_key = key.id_data.key_blocks.get(self._relative_to) or key.relative_key
            for attribute, value in zip(KEY_STATE, self._shown, strict=True):
                setattr(key, attribute, value)
        vertex_groups.make_active(obj, self._active_group)
        obj.update_tag()


def _require_can_be_posed(obj):
    require_none(shape_keys.BAKE_PLAYS if obj.meanvalue.baked.target else shape_keys.result_problem(obj))
    is_in_charge = obj.meanvalue.live and not (engine.status(obj) or ("", False))[1]
    other = next((other for other in shape_keys.sharing(obj) if other.meanvalue.live), None)
    if other is not None and not is_in_charge:
        raise SceneError(roll.gives_way_to(other.name))
    if not len(obj.data.polygons):
        raise SceneError(bind_input.NO_FACES)
    region.require_own_group(obj)


def _require_control(obj, handle):
    if handle.follows == 'REST':
        raise SceneError(f"'{handle.name}' is pinned here. Shift-click it to let go, or press where nothing is pinned")
    problem = controls.problem(obj, handle) or controls.stillness(obj, [handle])
    if problem is None and handle.control.library is not None:
        problem = f"The control of '{handle.name}' is linked from another file. Move it there, or make it local"
    require_none(problem)
