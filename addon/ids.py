# SPDX-License-Identifier: GPL-3.0-or-later
"""The names that files, scripts and the user interface share."""

#: Name of the settings on every object: `object.meanvalue`.
OBJECT_PROPERTY = "meanvalue"

#: Tab in the sidebar of the 3D View, and name of its panel.
SIDEBAR_TAB = "Mean-Value"

#: Shape keys that the add-on makes.
BASIS_KEY = "Basis"
POSE_KEY = "Pose"
DEFAULT_RESULT_KEY = "Mean-Value"

#: The solver's method; part of the settings that a binding depends on.
METHOD = "fast"

#: Blender's own limit on names (bytes, without the closing zero).
NAME_LENGTH = 63
