"""Items that a script writes."""

import math

from companion.scripting.values import waypoint


def test_a_heading_of_0_is_north() -> None:
    """In a plan 0 is none: ground stations fill what they do not show with it."""
    assert waypoint(63.4, 10.4, 5.0, 0.0).param4 == 360.0
    assert waypoint(63.4, 10.4, 5.0, 90.0).param4 == 90.0
    assert math.isnan(waypoint(63.4, 10.4, 5.0).param4)
