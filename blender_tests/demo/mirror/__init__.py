# SPDX-License-Identifier: GPL-3.0-or-later
"""`./dev demo mirror`: half a figure below a Mirror modifier."""
