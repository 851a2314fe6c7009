# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys that turn and parts that are grafted, on the project's own models."""
