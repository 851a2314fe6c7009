# SPDX-License-Identifier: GPL-3.0-or-later
"""The names that files, scripts and the user interface share."""

#: Name of the settings on every object: `object.meanvalue`.
OBJECT_PROPERTY = "meanvalue"

#: Of these settings: how many migrations posing/old_files.py has.
SETTINGS_VERSION = 2

#: Tab in the sidebar of the 3D View, and name of its panel.
SIDEBAR_TAB = "Mean-Value"

#: Shape keys that the add-on makes.
BASIS_KEY = "Basis"
RIG_POSE_KEY = "Rig Pose"
CORRECTIVE_KEY = "Corrective"
DEFAULT_RESULT_KEY = "Mean-Value"
MIX_KEY = "Rotation-Aware Mix"

#: How properties between bones and keys begin.
DRIVE_BY_POSE = "Drive by Pose"

#: Variable in the drivers of in-between keys, by which they are known whatever they are called and whose mesh it is.
MIX_MARK = "meanvalue_mix"

#: What Bake makes: the modifier, and the folder of caches beside the .blend.
CACHE_MODIFIER = "Mean-Value Cache"
CACHE_FOLDER = "meanvalue_cache"

#: Names that handles and pins begin with, and the mesh's attribute that says which vertices they have.
HANDLE_NAME = "Handle"
PIN_NAME = "Pin"
HANDLES_ATTRIBUTE = "meanvalue_handles"

#: The collection for controls that the add-on makes, and the custom property that it is known by.
CONTROLS_COLLECTION = "Mean-Value Controls"
CONTROLS_MARK = "meanvalue_controls"

#: Of pose objects: the custom property of their node groups, where vertices were, and how far they are from there.
POSE_NODES_MARK = "meanvalue_pose"
HOME_ATTRIBUTE = "meanvalue_home"
OFFSET_ATTRIBUTE = "meanvalue_offset"

#: Vertex group that the add-on makes.
REGION_GROUP = "Region"

#: The solver's methods (`method` of the native Deformer), and its default rigidity.
METHOD_FAST = "fast"
METHOD_PAPER = "paper"
METHOD_FULL = "full"
DEFAULT_RIGIDITY = 15.0

#: Where a mesh bends (`bend_at` of an object's settings).
BEND_EVERYWHERE = "EVERYWHERE"
BEND_RIG = "RIG"
BEND_POSES = "POSES"
BEND_PAINTED = "PAINTED"

#: What becomes of parts without a handle (`loose` of the native Deformer).
LOOSE_FOLLOW = "follow"
LOOSE_STAY = "stay"

#: What shows how a mesh bends (`pose_like` of an object's settings).
LIKE_NOTHING = "NOTHING"
LIKE_KEYS = "SHAPE_KEYS"
LIKE_RIG = "RIG"

#: Blender's own limit on names (bytes, without the closing zero).
NAME_LENGTH = 63
