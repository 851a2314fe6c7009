# SPDX-License-Identifier: GPL-3.0-or-later
"""When objects that are live are looked at, and when they are left alone. live/roll.py knows who they are."""

import contextlib
import traceback

import bpy
from bpy.app.handlers import persistent

from .. import compat, wording
from ..scene import kept, object_model, views
from ..scene.object_model import Change
from . import roll

#: How often it is looked whether a render has ended, if there is something left to do then.
WAIT_SECONDS = 0.5

#: What the panel says beforehand of what is animated, and with what else to mind.
WHILE_ANIMATED = "Renders and exports show one pose. Bake first{}"

_first_rendered = {}  # identity of an object: the first frame that was rendered, None once it was told of
untold = []  # notes on renders that no popup has shown

_said = []  # what the panels showed last
_is_rendering = False
_holds = 0  # how many are at work inside held()
_is_missed = False  # an update came meanwhile


# What Blender tells


def scene_updated(depsgraph, is_frame=False):
    """Blender evaluated the scene; is_frame: at another frame. Updates, which Blender finds by going through all that
    is in the scene, are not asked for where nothing follows, or was ever shown."""
    if (roll.has_any() or object_model.has_any()) and (is_frame or len(depsgraph.updates)):
        _notice_end_of_rendering()
        _take_note(depsgraph)
        follow_all(settles=is_frame and _is_captured())


def rendered_frame(depsgraph):
    """On the thread that renders: only looks, and leaves all else to the main thread. What is animated shows one pose
    there, since nothing follows. It is told by the console at once, and by a popup as soon as Blender calls a timer."""
    frame = depsgraph.scene.frame_current
    for key, obj, follower in roll.known() if _is_rendering else ():
        is_told = _first_rendered.setdefault(key, frame) in {frame, None}
        if not is_told and not obj.meanvalue.baked.target and follower.is_animated(obj):
            _first_rendered[key] = None
            what = f"The {follower.FOLLOWS} of '{obj.name}' are animated, but renders show one pose"
            tell_of_render(f"{what}. Bake, and render again")


def tell_of_render(note):
    untold.append(note)
    views.say(wording.sentence(note))


def forget_renders():
    _first_rendered.clear()
    untold.clear()


def _is_captured():
    """Whether whoever has changed the frame looks at it at once, such as a render of the viewport or an export, within
    an operator or a job. Blender's own loop draws it when it is ready."""
    if bpy.app.is_job_running('RENDER'):
        return True
    screens = [window.screen for window in bpy.context.window_manager.windows]
    is_shown = any(each.is_animation_playing or each.is_scrubbing for each in screens)
    return bpy.context.area is not None and not is_shown


def _take_note(depsgraph):
    """Tells the models of the objects what Blender evaluated, and finds objects that were turned live.

    An object is named wherever its evaluated mesh is another, be it that a bone of its rig has moved. Its mesh is named
    only where it was tagged, or has its shape keys mixed anew. What was tagged has all its flags, what is only
    evaluated again (sliders that are driven or animated) that of its geometry alone. So in 3.4 to 5.0, see
    test_live_recovery.py.
    """
    objects, named = [], {}  # session key: the update of a datablock
    for update in depsgraph.updates:
        if update.is_updated_geometry or update.is_updated_transform:
            datablock = update.id.original
            named[compat.session_key(datablock)] = update
            is_mesh = isinstance(datablock, bpy.types.Object) and datablock.type == 'MESH'
            objects += [datablock] if is_mesh and update.is_updated_geometry else []
    for obj in objects:
        change, is_rigged = _change_of(obj, named)
        if change is Change.MESH and not kept.told(obj.data):
            change = Change.KEYS
        for model in object_model.known_models(obj):
            if is_rigged:
                model.rig_moved()
            model.told(obj, change)
        roll.note(obj)


def look_for_live_objects():
    """After loading or undo everything may be another: forget, and see which objects are live."""
    forget()
    roll.search()
    _schedule()


@persistent
def meanvalue_render_started(*_):
    """While rendering, the mesh is left as it is: handlers run beside the interface then."""
    global _is_rendering
    _is_rendering = True
    forget_renders()
    for obj in [obj for _key, obj, follower in roll.known() if follower.is_behind(obj)]:
        tell_of_render(f"'{obj.name}' was still being solved when the render began. Wait for it, and render again")


@persistent
def meanvalue_render_ended(*_):
    """May be called on the thread that renders: only tells."""
    global _is_rendering
    _is_rendering = False


def _notice_end_of_rendering():
    """A render that fails to start never tells that it ended."""
    if _is_rendering and (bpy.app.background or not bpy.app.is_job_running('RENDER')):
        meanvalue_render_ended()


# Following


@contextlib.contextmanager
def held():
    """Inside, nothing follows: the scene is evaluated only to see where controls are, or to measure a rig."""
    global _holds
    _holds += 1
    try:
        yield
    finally:
        _holds -= 1


def follow_all(settles=False):
    """Every live object takes its controls, or its sliders, where they are; settles: waits for the last answer."""
    global _is_missed
    _is_missed = _holds > 0
    if _is_missed or _is_rendering:
        return
    have_all("finish" if settles or bpy.app.background else "follow")
    _schedule()


def have_all(act):
    """act: what all followers that may write are to do, by the name of the method."""
    with held():
        for obj, follower in roll.in_charge():
            with views.where_shown(obj), _reporting(follower):
                getattr(follower, act)(obj)


def _tick():
    """Timer: None ends it, a number calls it again after so many seconds."""
    global _is_missed
    _notice_end_of_rendering()
    while untold:
        views.pop_up("Mean-Value", wording.sentence(untold.pop(0)))
    if not (_is_rendering or _holds):
        is_missed, _is_missed = _is_missed, False
        have_all("follow" if is_missed else "tick")
    return _wait()


def _schedule():
    """Has _tick() be called when there is something to do: the timer may be waiting for the controls to rest."""
    if bpy.app.background:
        return
    wait = _wait()
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    if wait is not None:
        bpy.app.timers.register(_tick, first_interval=wait)


def _wait():
    """Seconds until _tick() is to be called, None for never."""
    _draw_status_again()
    if _is_rendering or _holds:
        return WAIT_SECONDS
    if _is_missed or untold:
        return 0.0
    waits = [follower.wait(obj) for obj, follower in roll.live_objects()]
    return min((each for each in waits if each is not None), default=None)


@contextlib.contextmanager
def _reporting(follower):
    """An error that nobody foresaw ends the work on one object alone, and is told."""
    try:
        yield
    except Exception as error:
        traceback.print_exc()
        follower.give_up(f"the add-on failed ({type(error).__name__}: {error}). Report it, and turn Live off and on")


def forget():
    roll.forget()
    forget_renders()


def shut_down():
    forget()
    meanvalue_render_ended()
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)


# What others ask


def look_again(obj):
    """An operator changes what `obj` is posed by: nothing that was known of it may be written any more."""
    object_model.edited(obj)
    follower = roll.follower_of(obj)
    if follower is not None:
        follower.look_again()
        _schedule()  # an operator that is refused after all changes nothing that Blender would tell of


def is_settled(obj):
    """Whether the mesh shows the settled answer to where the controls are, or live posing has no say in it."""
    follower = roll.follower_of(obj)
    return follower is None or follower.is_settled(obj)


def status(obj):
    """(text, whether it is a problem) of what the artist has to know of how `obj` follows; None if all is well."""
    follower = roll.follower_of(obj)
    if follower is None:
        return None
    why_hidden = follower.why_hidden(obj) if follower.problem is None else None
    if why_hidden:
        return wording.sentence(why_hidden), True
    said = follower.status(obj)
    if said is None and not obj.meanvalue.baked.target and follower.is_animated(obj):
        return wording.sentence(WHILE_ANIMATED.format(follower.AND_EXPORTS)), False
    return said


def _draw_status_again():
    global _said
    saying = [follower.status(obj) for obj, follower in roll.live_objects()]
    if saying != _said:
        _said = saying
        views.draw_again('UI')
        views.draw_again('WINDOW', 'PROPERTIES')


def _change_of(obj, named):
    """(Change, whether its modifiers may make something else of it)."""
    mesh = named.get(compat.session_key(obj.data))
    keys = named.get(compat.session_key(obj.data.shape_keys)) if obj.data.shape_keys else None
    if mesh is None and keys is None:
        return Change.RIG, True
    is_rigged = named[compat.session_key(obj)].is_updated_transform or any(
        compat.session_key(each) in named for each in _modified_by(obj)
    )
    if obj.data.is_editmode or keys is None or (mesh is not None and mesh.is_updated_shading):
        return Change.MESH, is_rigged
    return Change.KEYS if keys.is_updated_transform else Change.SLIDERS, is_rigged


def _modified_by(obj):
    """The objects that the modifiers take, and the one that `obj` hangs on, which may deform it."""
    if obj.parent is not None and obj.parent_type != 'OBJECT':  # else its place is all that counts
        yield obj.parent
    for modifier in obj.modifiers:
        for setting in modifier.bl_rna.properties:
            if setting.type == 'POINTER' and isinstance(setting.fixed_type, bpy.types.Object):
                other = getattr(modifier, setting.identifier)
                if other is not None:
                    yield other
