# SPDX-License-Identifier: GPL-3.0-or-later
"""What everyday posing does without: a region grown from a handle or painted; binding a mesh, posing it once, by its
handles or a shape key; what is messy about it; and what a report of a bug should say, without names and paths."""

import contextlib
import json
import platform

import bpy
import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene import along, kept, mesh_arrays, mirrors, shape_keys, subject
from ...solver import native_loader, session
from ...solver.core import result
from ...widgets.background import BackgroundOperator
from ...widgets.base import MeshOperator, Reporting
from ..bridge import controls, members, region, scene_input, targets
from ..bridge.scene_input import CONTROLS, Posing, release
from ..core import mesh_problems

#: Distance to begin with, as a share of the bounding-box diagonal of the mesh.
FIRST_DISTANCE = 0.2


class MEANVALUE_OT_grow_region(MeshOperator, bpy.types.Operator):
    """Make the region by growing it over the surface from the active handle"""

    bl_label = "Grow Region from Handle"
    problems = (controls.none_active,)

    distance: bpy.props.FloatProperty(
        name="Distance",
        description="How far it reaches over the rest shape, in the object's units; at first a fifth of its size",
        default=1.0,
        min=0.0,
        subtype='DISTANCE',
    )
    extend: bpy.props.BoolProperty(
        name="Extend", description="Add to the region that is there, in place of replacing it", default=False
    )

    def run(self, obj):
        settings = obj.meanvalue
        region.require_own_group(obj)
        handle = settings.handles[settings.active_handle]
        members.require_listed(obj, handle)
        (seeds,) = members.of(obj, [handle])
        if len(seeds) == 0:
            raise SceneError(f"Handle '{handle.name}' has no vertices to grow from. Assign some, or choose another")
        if not self.properties.is_property_set("distance"):
            self.distance = region.radius(obj, FIRST_DISTANCE)
        distances = region.Surface(obj, seeds).distances(self.distance)
        weights = (distances <= self.distance).astype(float)
        if self.extend:
            weights = np.maximum(weights, region.weights(obj))
        region.write(obj, weights)
        count = wording.vertices(np.count_nonzero(weights))
        return f"The region '{settings.roi_group}' has {count} around '{handle.name}'", []


def _unpaintable(obj):
    """Why the object cannot be painted, in words, or None."""
    problem = None if obj.mode == 'WEIGHT_PAINT' else subject.mode_problem(obj)
    return problem or (None if obj.visible_get() else f"'{obj.name}' is hidden, so it cannot be painted. Show it first")


class MEANVALUE_OT_paint_region(MeshOperator, bpy.types.Operator):
    """Paint the region: what has a weight may move. Press again when it is right"""

    bl_label = "Paint Region"
    needs_object_mode = False
    problems = (_unpaintable,)

    def run(self, obj):
        if obj.mode == 'WEIGHT_PAINT':
            bpy.ops.object.mode_set(mode='OBJECT')
            return "The region is painted", []
        region.require_own_group(obj)
        group = region.ensure_group(obj)
        obj.vertex_groups.active_index = group.index
        subject.choose(obj)
        bpy.ops.object.mode_set(mode='WEIGHT_PAINT')
        return f"Paint region '{group.name}': what has a weight may move. Press Paint Region again when it is right", []


class MEANVALUE_OT_bind(BackgroundOperator, bpy.types.Operator):
    """Take the mesh as it was edited for the rest shape, and give handles without a control one of their own"""

    bl_label = "Update"
    doing = "Updating"
    problems = (scene_input.unheld_problem,)

    def prepare(self, obj):
        return Posing(obj, is_checked=False)

    def finish(self, obj, posing, _outcome):
        handles = targets.followed_handles(obj)
        controls.require_places(obj, handles)  # throws before anything is changed
        bound = obj.meanvalue.bound
        if bound.is_bound and bound.rest_shape != posing.bind_input.fingerprint.rest_shape:
            # Edited, subdivided, scaled: controls, not moved for that, move their handles from where these are now.
            controls.attach_where_they_are(obj, handles, [controls.shown_move(obj, handle) for handle in handles])
        controls.remove_deleted(obj)
        # Of those that are missing or belong to another object, as after duplicating. Its own that are in no
        # collection, as when it was appended alone, are put back.
        lone = [handle for handle in targets.enabled_handles(obj) if handle.follows == 'CONTROL']
        lone = [handle for handle in lone if controls.why_it_is_missing(obj, handle)]
        for handle, vertices in zip(lone, members.of(obj, lone), strict=True):
            if handle.made_control and controls.owner_of(handle.control) == obj:
                controls.put_beside(obj, handle.control)
            else:
                controls.add_control(obj, handle, vertices, handle.color)
        posing.record(obj)
        message = f"Updated. {wording.counted(len(lone), 'control')} made" if lone else "Updated"
        return message, posing.binding.notes


class MEANVALUE_OT_unbind(MeshOperator, bpy.types.Operator):  # in no menu; scripts rely on its name
    """Forget the binding and free its memory, for scripts. Handles, region and shape keys stay as they are"""

    bl_label = "Unbind"
    needs_object_mode = False
    problems = (lambda obj: None if obj.meanvalue.bound.is_bound else f"'{obj.name}' is not bound",)

    def run(self, obj):
        release(obj.meanvalue.bound)
        return f"'{obj.name}' is no longer bound", []


class SolvingOperator(BackgroundOperator):
    """Mix-in: finish() for subclasses whose prepare() gives a Posing with targets."""

    doing = "Solving"

    def finish(self, obj, posing, outcome):
        shape, solution = outcome
        warnings = [
            *posing.binding.notes,
            *result.pose_warnings(posing.bind_input, posing.targets.positions),
            *targets.held_back_notes(posing.targets.held_back),
        ]
        if not solution.converged:
            why = f"It stopped before it had converged ({solution.stop_reason})"
            warnings.append(f"{why}. Look at the shape, or move handles less")
        notes = along.write_result(obj, shape)
        posing.record(obj)
        return ". ".join([f"Solved into '{obj.meanvalue.result_key}'", *notes, *subject.sharing_notes(obj)]), warnings


class MEANVALUE_OT_solve(SolvingOperator, bpy.types.Operator):
    """Pose the mesh once: handles go where their controls are, the rest follows"""

    bl_label = "Solve"
    problems = (scene_input.unheld_problem, targets.problem)

    def prepare(self, obj):
        return Posing(obj, CONTROLS)


def _without_keys(obj):
    why = "There are no shape keys. Add one, and move the vertices of handles in it, in Edit Mode"
    return None if obj.data.shape_keys else why


class MEANVALUE_OT_solve_from_key(SolvingOperator, bpy.types.Operator):
    """Put handles and pins where a shape key has their vertices, and the rest of the mesh after them, once"""

    bl_label = "Solve from Shape Key"
    problems = (scene_input.unheld_problem, _without_keys, shape_keys.result_problem)

    key: bpy.props.StringProperty(
        name="Shape Key", description="Shape key in which vertices of handles were moved. If empty, the active one"
    )

    def prepare(self, obj):
        active = obj.active_shape_key
        if not self.key and active in {None, obj.data.shape_keys.reference_key}:
            raise SceneError("The active shape key is the rest shape. Choose one in which vertices were moved")
        self.key = self.key or active.name
        return Posing(obj, self.key)

    def finish(self, obj, posing, outcome):
        notes, key = [], obj.data.shape_keys.key_blocks[self.key]
        is_result = self.key == obj.meanvalue.result_key
        moved = (shape_keys.positions(key) != posing.bind_input.rest).any(axis=1)
        moved[posing.bind_input.anchors] = False
        if moved.any() and not is_result:
            count = wording.counted(np.count_nonzero(moved), "vertex", "vertices")
            notes.append(f"{count} moved in '{self.key}' belong to no handle and are ignored")
        if obj.meanvalue.live:
            obj.meanvalue.live = False
            notes.append("Live is off: it would have the controls pose the mesh again")
        message, warnings = super().finish(obj, posing, outcome)
        if not is_result and key.value != 0.0:
            key.value = 0.0
            message += f". Shape key '{self.key}' has the value 0 now, so that it is not added"
        return message, [*warnings, *notes]


ALL = 'ALL'


class MEANVALUE_OT_select_problems(MeshOperator, bpy.types.Operator):
    """Select vertices of the mesh that are unusual, in Edit Mode. None of it stops posing"""

    bl_label = "Select Problem Vertices"

    kind: bpy.props.EnumProperty(
        name="Kind",
        description="What to select",
        items=((ALL, "All", "Whatever is unusual"), *mesh_problems.KINDS),
        default=ALL,
    )

    def run(self, obj):
        rest = shape_keys.rest_positions(obj.data)
        triangles, twins, copies = (
            mesh_arrays.triangles(obj.data, rest),
            mirrors.partners(obj, rest),
            kept.copies(obj, rest),
        )
        report = places = None  # what only a binding knows, where there is one that fits the scene
        with contextlib.suppress(SceneError):  # no handles yet, say: the mesh can be looked at all the same
            bind_input = scene_input.gather(obj)
            places, binding = bind_input.solver_mesh.places, session.cache.get(bind_input.fingerprint)
            report = binding.deformer.report if binding is not None else None
        found, distance = mesh_problems.find(rest, triangles, report, places, twins, copies)
        if self.kind == 'BAKED' and obj.meanvalue.baked.worst:
            frame, vertices = json.loads(obj.meanvalue.baked.worst)
            found['BAKED'] = [vertex for vertex in vertices if vertex < len(rest)]  # some may be deleted by now
            bpy.context.scene.frame_set(int(frame))
        chosen = {kind: vertices for kind, vertices in found.items() if self.kind in {ALL, kind}}
        if not chosen:
            return f"Nothing {'unusual' if self.kind == ALL else 'of that kind'} was found on '{obj.name}'", []
        vertices = np.unique(np.concatenate(list(chosen.values())))
        subject.choose(obj)
        notes = subject.edit_with_selected(obj, vertices)
        names = {kind: name for kind, name, _about in mesh_problems.KINDS}
        names['GAP'] += f", closed by Merge Distance {distance:g}"
        counts = wording.listed(f"{names[kind]} ({len(each):,})" for kind, each in chosen.items())
        return f"{wording.vertices(len(vertices))} selected: {counts}", notes


class MEANVALUE_OT_copy_system_info(Reporting, bpy.types.Operator):
    """Copy versions, counts and settings to the clipboard, for reports of bugs. No names, no paths"""

    bl_label = "Copy System Info"
    bl_options = {'REGISTER'}

    def execute(self, context):
        lines = [f"{label}: {value}" for label, value in _facts(subject.of(context))]
        text = "\n".join(lines) + "\n"
        context.window_manager.clipboard = text
        if bpy.app.background:  # which has no clipboard
            print(text)
        self.report({'INFO'}, "Copied. Paste it into the report.")
        return {'FINISHED'}


def _facts(obj):
    package = __package__.removesuffix(".posing.operators")
    yield "Mean-Value Deform", "extension" if package.startswith("bl_ext.") else "legacy add-on"
    if native_loader.problem() is None:
        info = native_loader.module().build_info()
        yield "Solver", f"{native_loader.module().__version__}, {', '.join(f'{key} {info[key]}' for key in info)}"
    else:
        yield "Solver", "cannot be loaded"
    yield "Blender", f"{bpy.app.version_string}, Python {platform.python_version()}, numpy {np.__version__}"
    yield "System", f"{platform.platform()}, {platform.processor() or platform.machine()}"
    problem = subject.object_problem(obj)
    yield "Active object", f"{obj.type if obj else 'none'}{' that cannot be posed' if problem else ''}"
    if problem:
        return
    mesh, settings = obj.data, obj.meanvalue
    yield "Vertices, edges, faces", f"{len(mesh.vertices):,}, {len(mesh.edges):,}, {len(mesh.polygons):,}"
    yield "Mode", obj.mode
    yield "Scale", ", ".join(f"{part:g}" for part in obj.scale)
    yield "Modifiers", ", ".join(modifier.type for modifier in obj.modifiers)
    yield "Handles and pins, region", f"{len(settings.handles)}, {bool(settings.roi_group)}"
    yield "Live, bound, baked", f"{settings.live}, {settings.bound.is_bound}, {settings.baked.target or False}"
    for name in type(settings).__annotations__:
        setting = settings.bl_rna.properties[name]
        if setting.type in {'BOOLEAN', 'INT', 'ENUM', 'FLOAT'}:  # names and lists are the artist's
            yield setting.name, getattr(settings, name)
