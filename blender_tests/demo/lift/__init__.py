# SPDX-License-Identifier: GPL-3.0-or-later
"""`./dev demo lift`: an animated picture of the octopus."""
