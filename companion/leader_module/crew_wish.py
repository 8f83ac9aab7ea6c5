"""What the crew of a lead boat asks of the follower."""

from __future__ import annotations

from companion.core.readings import Wish

_MOST = 255


class CrewWish:
    """`wish`: NONE until the crew first presses; `presses`: counts them, with 1 after 255."""

    def __init__(self) -> None:
        self.wish = Wish.NONE
        self.presses = 0

    def press(self, wish: Wish) -> None:
        """The crew asks for `wish`; the same again asks anew."""
        self.wish = wish
        self.presses = self.presses % _MOST + 1
