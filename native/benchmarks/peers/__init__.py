# SPDX-License-Identifier: MPL-2.0
"""Our methods and the peers in one calling form: a job in a folder, a process of its own, a result in that folder.

A process each, so that the peak memory is the method's own, a time limit can end it, and a crash is one table row.
"""
