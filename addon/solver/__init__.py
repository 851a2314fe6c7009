# SPDX-License-Identifier: GPL-3.0-or-later
"""The native module: how it is found, the deformers of this session, and jobs."""
