"""Work in shards: a pure function over items, in this process, in several, or on a cluster of machines.

What a function returns must not depend on where or when it is called, so that results are the same for any number of
workers, bit by bit.
"""

from __future__ import annotations

from kinetograph.work.seeing import require_seen
from kinetograph.work.shards import HERE, Store, Workers, hands, in_shards
from kinetograph.work.staying import Room, rooms

__all__ = ["HERE", "Room", "Store", "Workers", "hands", "in_shards", "require_seen", "rooms"]
