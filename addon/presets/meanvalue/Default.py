# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

settings = (bpy.context.object if bpy.context.object.type == 'MESH' else bpy.context.object.parent).meanvalue

settings.method = 'fast'
settings.rigidity = 15.0
