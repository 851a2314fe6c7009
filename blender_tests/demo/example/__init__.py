# SPDX-License-Identifier: GPL-3.0-or-later
"""`./dev demo example`: figures posed by handles like their own rigs."""
