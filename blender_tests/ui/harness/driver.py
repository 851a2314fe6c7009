# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scenario can do at Blender's interface, and see of it.

Acts are for `yield from`. Blender handles all that an act did, and draws, before the scenario goes on: there is
nothing to wait for but what Blender itself puts off.
"""

import os
import pathlib
import time

import bpy
from demo import pictures

from . import display, message_log, status_bar, tabs, view
from .acting import act

WAIT_SECONDS = 150.0
#: Blender lets panels slide for 0.3 s to where they belong when one above them has another height.
PANELS_SLIDE_SECONDS = 0.5
# On no keyboard, so in no keymap.
UNUSED_KEY = 'F24'
TYPED = {
    **{"0": 'ZERO', "1": 'ONE', "2": 'TWO', "3": 'THREE', "4": 'FOUR'},
    **{"5": 'FIVE', "6": 'SIX', "7": 'SEVEN', "8": 'EIGHT', "9": 'NINE'},
    **{".": 'PERIOD', "-": 'MINUS', " ": 'SPACE'},
    **{letter: letter.upper() for letter in "abcdefghijklmnopqrstuvwxyz"},
}


class Ui:
    """One for each scenario. `tell(step)` takes what is done, in words; `pictures` is a folder."""

    def __init__(self, tell, pictures):
        self._tell = tell
        self._pictures = pictures
        self._mouse = view.centre()
        self._reports_before = len(message_log.reports())

    # Acts

    @act
    def key(self, key, *, shift=False, ctrl=False, alt=False, unicode=""):
        """Presses and releases a key: 'G', 'RET', 'ESC', 'TAB', 'F3', as in a keymap item."""
        held = {"shift": shift, "ctrl": ctrl, "alt": alt}
        self._tell(f"key {' '.join([name for name, down in held.items() if down] + [key])}")
        yield from self._press(key, held, unicode)

    @act
    def type(self, text):
        """Small letters, digits, '.', '-' and ' ', one key after the other."""
        self._tell(f"type {text}")
        for letter in text:
            yield from self._press(TYPED[letter], {}, letter)

    @act
    def move_mouse(self, x, y):
        """To a place in the window, in pixels from its lower left."""
        self._tell(f"mouse to {x}, {y}")
        yield from self._move(x, y)

    @act
    def click(self, x, y, button='LEFTMOUSE', *, shift=False, ctrl=False, alt=False):
        self._tell(f"click {button} at {x}, {y}")
        yield from self._move(x, y)
        yield from self._press(button, {"shift": shift, "ctrl": ctrl, "alt": alt})

    @act
    def drag_mouse(self, start, end, steps=5, between=None):
        """With the left button held. `between` as in drag_by_keys."""
        self._tell(f"drag the mouse from {start} to {end}")
        yield from self._move(*start)
        self._send('LEFTMOUSE', 'PRESS')
        yield
        yield from self._glide(end, steps, between)
        self._send('LEFTMOUSE', 'RELEASE')
        yield

    @act
    def drag_by_keys(self, key, dx, dy, steps=5, between=None, end='RET', start=None):
        """Presses `key` ('G', 'R', 'S') over the 3D View, moves the mouse by (dx, dy) pixels, and presses `end`.

        `between(step)` is called after each of `steps` moves, step counting from 0; it may be a generator function.
        `start` is where the mouse begins, else the middle of the view. With end=None the operator is left running.
        """
        x, y = start or view.centre()
        self._tell(f"drag by {key} from {x}, {y} by {dx}, {dy}")
        yield from self._move(x, y)
        yield from self._press(key)
        yield from self._glide((x + dx, y + dy), steps, between)
        if end:
            yield from self._press(end)

    @act
    def invoke(self, operator, **properties):
        """Runs an operator as a button does: invoked in the 3D View by Blender itself, one undo step, reports logged.

        @throws AssertionError if the operator is not available.
        """
        self._tell(f"invoke {operator} {properties or ''}")
        module, _, name = operator.partition(".")
        with view.override():
            assert getattr(getattr(bpy.ops, module), name).poll(), f"{operator} is not available here"
        keymap = bpy.context.window_manager.keyconfigs.addon.keymaps.new(name="3D View", space_type='VIEW_3D')
        item = keymap.keymap_items.new(operator, UNUSED_KEY, 'PRESS')
        for key, value in properties.items():
            setattr(item.properties, key, value)
        try:
            yield from self._move(*view.centre())
            yield from self._press(UNUSED_KEY)
        finally:
            keymap.keymap_items.remove(item)

    @act
    def undo(self):
        """By Ctrl-Z over the 3D View."""
        self._tell("undo")
        yield from self._move(*view.centre())
        yield from self._press('Z', {"ctrl": True})

    @act
    def redo(self):
        """By Ctrl-Shift-Z over the 3D View."""
        self._tell("redo")
        yield from self._move(*view.centre())
        yield from self._press('Z', {"ctrl": True, "shift": True})

    @act
    def open_tab(self, category):
        """Opens the sidebar and clicks at its tab `category`."""
        self._tell(f"open the tab {category}")
        yield from tabs.open_tab(category, self._click_at_once)

    @act
    def wait_until(self, predicate, what):
        """For what Blender does later by itself. @throws AssertionError after 60 s."""
        self._tell(f"wait until {what}")
        until = time.monotonic() + WAIT_SECONDS
        while not predicate():
            assert time.monotonic() < until, f"waited {WAIT_SECONDS:.0f} s in vain until {what}"
            yield

    @act
    def pause(self, seconds):
        """Lets Blender run. Nothing may rely on how much it gets done."""
        self._tell(f"pause of {seconds} s")
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            yield

    @act
    def screenshot(self, name, amid_work=False):
        """Draws everything and writes build/ui/NAME.png: at once `amid_work`, else with all panels in their places."""
        self._tell(f"screenshot {name}")
        view.redraw()
        yield
        until = time.monotonic() + (0.0 if amid_work else PANELS_SLIDE_SECONDS)
        while time.monotonic() < until:
            yield
        self.photograph(name)

    # Not acts: done at once

    def photograph(self, name):
        """build/ui/NAME.png of what is drawn now. @throws AssertionError if that is of one colour."""
        shown = pathlib.Path(os.environ["MEANVALUE_UI_DISPLAY_FILE"])
        colours = display.photograph(shown, self._pictures / f"{name}.png")
        assert colours > 1, f"nothing is drawn: {name}.png is of one colour"

    def picture(self, name):
        """(height, width, 4) float32 of build/ui/NAME.png, from the lower left as project() counts."""
        return pictures.read_png(self._pictures / f"{name}.png")

    def remember(self):
        """An undo step for what the scenario itself did to the scene; without it, undo would take that back as well."""
        self._tell("remember")
        with view.override():
            bpy.ops.ed.undo_push(message="Scenario")

    def frame_all(self):
        """Shows all objects in the 3D View."""
        view.frame_all()

    def project(self, location):
        """(x, y) in the window of a location in the world."""
        return view.project(location)

    def reports(self):
        """The lines of the Info editor since the scenario began: operators as Python, and messages as shown."""
        return message_log.reports()[self._reports_before :]

    def status_text(self):
        """What Python last put into the status bar; None if that was taken away again."""
        return status_bar.text()

    # Events

    def _send(self, key, value, held=None, **text):
        x, y = self._mouse
        view.window().event_simulate(key, value, x=x, y=y, **text, **(held or {}))

    def _press(self, key, held=None, unicode=""):
        self._send(key, 'PRESS', held, **({"unicode": unicode} if unicode else {}))
        self._send(key, 'RELEASE', held)
        yield

    def _move(self, x, y):
        self._mouse = (x, y)
        self._send('MOUSEMOVE', 'NOTHING')
        yield

    def _glide(self, end, steps, between):
        (x, y), (last_x, last_y) = self._mouse, end
        for step in range(steps):
            part = (step + 1) / steps
            yield from self._move(round(x + (last_x - x) * part), round(y + (last_y - y) * part))
            self._tell(f"move {step + 1} of {steps}")
            more = between(step) if between else None
            if more is not None:
                yield from more

    def _click_at_once(self, x, y):
        """For what needs no mouse resting on it. One picture drawn instead of two."""
        self._mouse = (x, y)
        self._send('MOUSEMOVE', 'NOTHING')
        yield from self._press('LEFTMOUSE')
