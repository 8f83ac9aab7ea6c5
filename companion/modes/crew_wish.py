"""What the crew of a lead boat asks of the follower, as the leader module keeps it."""

from __future__ import annotations

from companion.core.types import Wish

_MOST = 255


class CrewWish:
    """`press(wish)`: the crew decides; pressing for the same again asks for it anew. `wish` is NONE until the first press, `presses` counts them, 255 followed by 1."""

    def __init__(self) -> None:
        self.wish = Wish.NONE
        self.presses = 0

    def press(self, wish: Wish) -> None:
        self.wish = wish
        self.presses = self.presses % _MOST + 1
