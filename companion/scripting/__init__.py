"""Scripts of a boat's owner: Python programs in processes of their own, which read the feed and command by MAVLink.

What a script imports stands here; `docs/use/scripting.md` describes it.
"""

from __future__ import annotations

from companion.scripting.boat import Boat
from companion.scripting.client import ScriptError
from companion.scripting.values import Item, State, item, waypoint

__all__ = ["Boat", "Item", "ScriptError", "State", "item", "waypoint"]
