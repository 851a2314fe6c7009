# SPDX-License-Identifier: GPL-3.0-or-later
"""`./dev demo face`: values of shape keys from the markers of a generated face."""
