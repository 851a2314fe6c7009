# SPDX-License-Identifier: GPL-3.0-or-later
"""`./dev demo joints`: limbs that bend everywhere, and at their joints."""
