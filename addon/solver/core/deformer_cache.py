# SPDX-License-Identifier: GPL-3.0-or-later
"""What was bound last, within a limit of memory."""


class DeformerCache:
    """Keeps at most `capacity` entries and, but for the newest, at most `byte_limit` bytes.

    Only a cache: whatever is dropped is built again on demand, with the same result to the tolerance.
    """

    def __init__(self, capacity, byte_limit):
        self._capacity = capacity
        self._byte_limit = byte_limit
        self._entries = {}  # key: (entry, bytes, family), the newest last

    def get(self, key):
        """The entry, now the newest, or None."""
        found = self._entries.pop(key, None)
        if found is None:
            return None
        self._entries[key] = found
        return found[0]

    def relative(self, family):
        """The newest entry that was put with this family, or None. It stays as old as it is."""
        found = (entry for entry, _, its_family in reversed(self._entries.values()) if its_family == family)
        return next(found, None)

    def put(self, key, entry, byte_count, family=None):
        """family: what entries have in common that may be made from each other."""
        self._entries.pop(key, None)
        self._entries[key] = (entry, byte_count, family)
        total = sum(byte_count for _, byte_count, _ in self._entries.values())
        while len(self._entries) > 1 and (len(self._entries) > self._capacity or total > self._byte_limit):
            total -= self._entries.pop(next(iter(self._entries)))[1]

    def clear(self):
        self._entries.clear()
