# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

bpy.ops.meanvalue.use_preset(method='fast', rigidity=2.0)
