# SPDX-License-Identifier: GPL-3.0-or-later
"""The one error the demo answers: its message says what to do, and no traceback is shown."""


class DemoError(Exception):
    """Something in the command line, the file or the set-up that the user can put right."""
