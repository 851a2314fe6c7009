# SPDX-License-Identifier: GPL-3.0-or-later
"""Live as the interface has it, without a window: handlers only follow, and timers do the rest."""

import contextlib
import time
import types
from unittest import mock

import bpy

from . import installed


class Timers:
    """In place of bpy.app.timers. Time goes on by `seconds` for every step of run()."""

    def __init__(self):
        self._waiting = []
        self.first_intervals = {}  # function: what it was registered with last
        self.passed = 0.0

    def is_registered(self, function):
        return function in self._waiting

    def register(self, function, first_interval=0.0):
        self._waiting.append(function)
        self.first_intervals[function] = first_interval

    def unregister(self, function):
        self._waiting.remove(function)

    def run(self, seconds=0.0, most=10_000):
        """Calls timers until none wants to be called any more. Returns how often it has called."""
        calls = 0
        while self._waiting:
            self.step(seconds)
            calls += 1
            assert calls < most, "a timer runs for ever"
        return calls

    def step(self, seconds=0.0):
        """Calls the first timer that waits."""
        function = self._waiting.pop(0)
        self.passed += seconds
        if function() is not None and function not in self._waiting:
            self._waiting.append(function)
        time.sleep(0.0005)


@contextlib.contextmanager
def interface():
    """Inside, the add-on has a window for all it knows. Gives the Timers."""
    timers = Timers()
    app = types.SimpleNamespace(background=False, timers=timers, is_job_running=lambda _kind: False)
    seen = types.SimpleNamespace(app=app, data=bpy.data, types=bpy.types, context=bpy.context)
    clock = time.monotonic
    with contextlib.ExitStack() as stack:
        stack.enter_context(mock.patch.object(installed.part("live.engine"), "bpy", seen))
        for name in ("live.following", "scene.object_model"):
            stack.enter_context(mock.patch.object(installed.part(name), "clock", lambda: clock() + timers.passed))
        yield timers
        installed.part("live.engine").shut_down()
        installed.part("registration").meanvalue_leave_file()


def is_settled(obj):
    """Whether `obj` is live, and shows the answer to where its handles or sliders are, or tells why not; and nothing is
    left to do."""
    engine = installed.part("live.engine")
    follower = installed.part("live.roll").follower_of(obj)
    return follower is not None and follower.wait(obj) is None and engine.is_settled(obj)
