# SPDX-License-Identifier: GPL-3.0-or-later
"""Many things that artists do, in an order that nobody thought of, always the same.

After each the mesh is left to follow, and then everything has to fit together: no result of another mesh, no anchor
beside its control, no traceback. MEANVALUE_UI_SEED=2 and so on for other orders.
"""

import os
import pathlib
import random
import tempfile

import bpy
import numpy as np
from harness import view
from support import handles, installed, meshes
from support.handles import SEGMENTS

ROUNDS = 80
SEED = int(os.environ.get("MEANVALUE_UI_SEED", "1"))
LOG = pathlib.Path(os.environ["MEANVALUE_UI_PICTURES"], "random_actions.log")


def _engine():
    return installed.part("live.engine")


def _operate(operator, *arguments, **options):
    """An operator as from a button or menu, one undo step. What it cannot do here is left undone."""
    with view.override():
        if operator.poll():
            try:
                operator('EXEC_DEFAULT', True, *arguments, **options)
            except RuntimeError as error:  # refused; the report is checked like all others
                assert "Traceback" not in str(error), error


class Artist:
    """Chooses what to do next. Objects are looked up by name each time."""

    def __init__(self, ui, folder):
        self.ui = ui
        self.path = f"{folder}/random.blend"
        self.chance = random.Random(SEED)
        self.count = 0
        self.has_saved = False

    def mesh(self):
        """A mesh object of the scene; a new tube if there is none left."""
        found = sorted(obj.name for obj in bpy.context.scene.objects if obj.type == 'MESH')
        if not found:
            self.count += 1
            meshes.tube(handles.RINGS, SEGMENTS, f"Tube {self.count}")
            self.ui.remember()
            return bpy.context.object
        return bpy.data.objects[self.chance.choice(found)]

    def activate_mesh(self):
        obj = self.mesh()
        self.object_mode()
        if obj.name in bpy.context.view_layer.objects:
            meshes.activate(obj)
        return obj

    def object_mode(self):
        active = bpy.context.view_layer.objects.active
        if active is not None and active.mode != 'OBJECT':
            _operate(bpy.ops.object.mode_set, mode='OBJECT')

    def activate_control(self):
        self.object_mode()
        found = sorted(obj.name for obj in bpy.context.scene.objects if obj.type == 'EMPTY')
        if not found:
            return False
        meshes.activate(bpy.data.objects[self.chance.choice(found)])
        return True

    def ring(self):
        return self.chance.randrange(handles.RINGS)

    # What an artist does; each is a generator function

    def drag(self):
        if self.activate_control():
            end = self.chance.choice(['RET', 'RET', 'ESC'])
            key = self.chance.choice("GGRS")
            dx, dy = (self.chance.randint(-120, 120) for _ in range(2))
            yield from self.ui.drag_by_keys(key, dx, dy, steps=3, end=end)

    def add(self):
        obj = self.activate_mesh()
        ring = self.ring()
        for vertex in obj.data.vertices:
            vertex.select = vertex.index // SEGMENTS == ring
        for element in (*obj.data.edges, *obj.data.polygons):
            element.select = False
        _operate(bpy.ops.object.mode_set, mode='EDIT')
        yield
        _operate(bpy.ops.meanvalue.add_handle, pin=self.chance.choice([False, True]))
        yield

    def remove(self):
        obj = self.activate_mesh()
        if len(obj.meanvalue.handles):
            obj.meanvalue.active_handle = self.chance.randrange(len(obj.meanvalue.handles))
        _operate(bpy.ops.meanvalue.remove_handle)
        yield

    def press(self):
        self.activate_mesh()
        names = ("bind", "solve", "keep_pose", "apply_pose", "reset_handles")
        yield from ()
        _operate(getattr(bpy.ops.meanvalue, self.chance.choice(names)))

    def change_setting(self):
        settings = self.activate_mesh().meanvalue
        what = self.chance.randrange(6)
        if not settings.live:
            settings.live = True
        elif what == 0:
            settings.rigidity = self.chance.choice([0.0, 2.0, 15.0])
        elif what == 1 and len(settings.handles):
            line = self.chance.choice(settings.handles)
            line.is_enabled = not line.is_enabled
        elif what == 2 and len(settings.handles):
            line = self.chance.choice(settings.handles)
            line.is_soft = not line.is_soft
        elif what == 3:
            settings.live = False
        self.ui.remember()
        yield

    def switch_mode(self):
        self.activate_mesh()
        _operate(bpy.ops.object.mode_set, mode=self.chance.choice(['EDIT', 'SCULPT', 'WEIGHT_PAINT']))
        yield
        if self.chance.random() < 0.7:
            self.object_mode()
            yield

    def edit(self):
        obj = self.activate_mesh()
        ring = self.ring()
        for vertex in obj.data.vertices:
            vertex.select = vertex.index // SEGMENTS == ring
        _operate(bpy.ops.object.mode_set, mode='EDIT')
        yield
        what = self.chance.randrange(4)
        if what == 0:
            _operate(bpy.ops.mesh.subdivide)
        elif what == 1:
            _operate(bpy.ops.mesh.delete, type='FACE')
        else:
            _operate(bpy.ops.transform.translate, value=(0.2, 0.0, 0.1))
        yield
        self.object_mode()
        yield

    def undo(self):
        for _ in range(self.chance.randint(1, 3)):
            yield from self.ui.undo()

    def redo(self):
        for _ in range(self.chance.randint(1, 3)):
            yield from self.ui.redo()

    def duplicate(self):
        if len(bpy.context.scene.objects) < 8:
            self.activate_mesh()
            _operate(bpy.ops.object.duplicate)
        yield

    def delete(self):
        if self.chance.random() < 0.5 or not self.activate_control():
            self.activate_mesh()
        _operate(bpy.ops.object.delete)
        yield

    def rename(self):
        self.count += 1
        self.activate_mesh().name = f"Renamed {self.count}"
        self.ui.remember()
        yield

    def save(self):
        bpy.ops.wm.save_as_mainfile(filepath=self.path, check_existing=False)
        self.has_saved = True
        yield

    def reload(self):
        if self.has_saved:
            bpy.ops.wm.open_mainfile(filepath=self.path)
        yield
        yield

    def play(self):
        yield from self.ui.key('SPACE')
        yield from self.ui.pause(0.3)
        yield from self.ui.key('SPACE')

    def choose(self):
        weights = {
            self.drag: 40, self.add: 18, self.remove: 4, self.press: 14, self.change_setting: 10, self.switch_mode: 6,
            self.edit: 8, self.undo: 16, self.redo: 8, self.duplicate: 3, self.delete: 4, self.rename: 3, self.save: 4,
            self.reload: 7, self.play: 2,
        }  # fmt: skip
        return self.chance.choices(list(weights), list(weights.values()))[0]


def _is_quiet():
    """Nothing runs and nothing is to come."""
    return all(_engine().is_settled(obj) for obj in bpy.data.objects if obj.meanvalue.live)


def _check_consistency():
    for obj in bpy.data.objects:
        keys = obj.data.shape_keys if obj.type == 'MESH' else None
        if keys is None or obj.mode == 'EDIT':
            continue
        assert all(len(key.data) == len(obj.data.vertices) for key in keys.key_blocks), obj.name
        live = _engine().status(obj)
        if obj.meanvalue.live and (live is None or not live[1]) and obj.mode == 'OBJECT' and keys:
            _check_anchors(obj, keys)


def _check_anchors(obj, keys):
    """Every hard handle is where its control has it, every pin is at rest."""
    control_places = installed.part("posing.bridge.control_places")
    rest = np.array([tuple(point.co) for point in keys.reference_key.data])
    result = np.array([tuple(point.co) for point in keys.key_blocks[obj.meanvalue.result_key].data])
    assert np.isfinite(result).all()
    taken = set()
    for line in obj.meanvalue.handles:
        held = installed.part("posing.bridge.members").of(obj, [line])[0].tolist() if line.is_enabled else []
        members = [vertex for vertex in held if vertex not in taken]
        taken.update(members)
        if not members or line.is_soft:
            continue
        move = np.eye(4) if line.follows == 'REST' else control_places.move(obj, line)
        wanted = rest[members] @ move[:3, :3].T + move[:3, 3]
        error = np.abs(result[members] - wanted).max()
        assert error < 1e-3 * (1.0 + np.abs(wanted).max()), (obj.name, line.name, error)


def eighty_rounds(ui):
    with tempfile.TemporaryDirectory() as folder:
        artist = Artist(ui, folder)
        for number in range(ROUNDS):
            action = artist.choose()
            ui._tell(f"round {number}: {action.__name__}")
            yield from action()
            yield from ui.wait_until(_is_quiet, f"round {number}, {action.__name__}, is quiet")
            _check_consistency()
            if number % 20 == 19:
                yield from ui.screenshot("random_actions", amid_work=True)
        shown = "\n".join([*ui.reports(), LOG.read_text(errors="replace")])
        assert "Traceback" not in shown and "Error: Python" not in shown, shown
