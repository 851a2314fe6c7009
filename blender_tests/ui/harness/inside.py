# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs scenarios in Blender's event loop; started by process.py.

    blender ... --python inside.py -- SCENARIO_FILE EVENTS_FILE NAME...

Writes {"begin"}, {"step"} and {"end"} lines of JSON to EVENTS_FILE, and a line "@@ NAME" to the output where a scenario
begins. Every scenario starts with an empty factory scene and the add-on enabled.
"""

import importlib.util
import json
import os
import pathlib
import sys
import time
import traceback

import bpy

HERE = pathlib.Path(__file__).resolve().parent
PICTURES = pathlib.Path(os.environ["MEANVALUE_UI_PICTURES"])
SIDEBAR_TAB = "Mean-Value"
STEP_SECONDS = 0.01

sys.path[:0] = [str(HERE.parents[2]), str(HERE.parents[1]), str(HERE.parent)]
from support import installed  # noqa: E402

from harness import acting, status_bar, view  # noqa: E402
from harness.driver import Ui  # noqa: E402


class Runner:
    """Timer function: goes on to the next `yield` each time it is called."""

    def __init__(self, scenario_file, events_file, names):
        self._file = pathlib.Path(scenario_file)
        self._events = pathlib.Path(events_file).open("a", buffering=1)  # noqa: SIM115  open until Blender ends
        self._names = names
        self._course = None

    def __call__(self):
        try:
            self._course = self._course or self._all()
            next(self._course)
        except StopIteration:
            bpy.ops.wm.quit_blender()
            return None
        except BaseException:  # a timer's exception would leave the window open for ever
            traceback.print_exc()
            sys.stderr.flush()
            os._exit(1)
        return STEP_SECONDS

    def _tell(self, **event):
        self._events.write(json.dumps(event) + "\n")

    def _all(self):
        for name in self._names:
            print("@@", name, flush=True)
            self._tell(begin=name)
            started = time.monotonic()
            problems = []
            yield from self._guarded(name, self._fresh_scene(), problems)
            if not problems:
                yield from self._guarded(name, self._scenario(name), problems)
            if acting.forgotten:
                problems.append(f"not done, `yield from` is missing: {', '.join(acting.forgotten)}")
                acting.forgotten.clear()
            yield
            sys.stdout.flush()
            self._tell(end=name, problems=problems, seconds=time.monotonic() - started)

    def _fresh_scene(self):
        """Ends what may still run, and loads the factory's file without its objects."""
        for value in ('PRESS', 'RELEASE') * 2:
            x, y = view.centre()
            view.window().event_simulate('ESC', value, x=x, y=y)
            yield
        # Not read_factory_settings, which disables add-ons. Without an override: the window is replaced.
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        yield
        assert bpy.context.preferences.addons.get(installed.PACKAGE), "the add-on was disabled"
        status_bar.forget()
        view.redraw()
        yield

    def _scenario(self, name):
        spec = importlib.util.spec_from_file_location(self._file.stem, self._file)
        module = sys.modules.get(self._file.stem) or importlib.util.module_from_spec(spec)
        if self._file.stem not in sys.modules:
            spec.loader.exec_module(module)
            sys.modules[self._file.stem] = module
        ui = Ui(lambda step: self._tell(step=step), PICTURES)
        course = getattr(module, name)(ui)
        assert course is not None, f"{name} is no generator: it has no yield"
        yield from course

    def _guarded(self, name, course, problems):
        """As `yield from course`, with its exception among `problems` and a picture."""
        try:
            yield from course
        except BaseException as error:
            if isinstance(error, GeneratorExit):
                raise
            problems.append(traceback.format_exc())
            picture = f"failed-{self._file.stem}-{name}"
            try:
                Ui(lambda step: None, PICTURES).photograph(picture)
                problems.append(f"picture: build/ui/{picture}.png")
            except Exception:
                problems.append(f"no picture:\n{traceback.format_exc()}")


def start():
    sys.stdout.reconfigure(line_buffering=True)
    preferences = bpy.context.preferences
    preferences.view.show_splash = False
    preferences.view.smooth_view = 0  # views jump
    preferences.system.viewport_aa = 'OFF'  # else every picture is drawn eight times
    preferences.use_preferences_save = False
    if installed.IS_EXTENSION:  # it was installed before this Blender started
        installed.enable()
    else:
        installed.install()
    status_bar.watch()
    arguments = sys.argv[sys.argv.index("--") + 1 :]
    # Persistent: loading a file ends other timers.
    bpy.app.timers.register(Runner(*arguments[:2], arguments[2:]), first_interval=0.5, persistent=True)


start()
