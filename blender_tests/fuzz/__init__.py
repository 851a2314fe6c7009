# SPDX-License-Identifier: GPL-3.0-or-later
"""Fuzzing of what reads files: `./dev fuzz readers`. The solver's fuzzers are in native/fuzz/."""
