# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C while Blender works without a window: it only takes note of it, and goes on."""

import contextlib
import ctypes
import signal


@contextlib.contextmanager
def calling(action):
    """Inside, Ctrl-C (SIGINT) calls `action()`; afterwards it does what it did before. On the main thread only."""
    api = ctypes.pythonapi  # Blender's handler is no Python function: `signal` alone could not put it back
    api.PyOS_getsig.restype, api.PyOS_getsig.argtypes = ctypes.c_void_p, [ctypes.c_int]
    api.PyOS_setsig.restype, api.PyOS_setsig.argtypes = ctypes.c_void_p, [ctypes.c_int, ctypes.c_void_p]
    former, known = api.PyOS_getsig(signal.SIGINT), signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, lambda *_: action())
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL if known is None else known)
        api.PyOS_setsig(signal.SIGINT, former)
