# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels. They only draw: no decisions, no writes."""
