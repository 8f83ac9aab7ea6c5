"""What failed thrusters leave the boat able to do, and what the supervisor makes of it."""

from __future__ import annotations

import pytest

from companion.allocation.propulsion import keeps_straight, lost_motions
from companion.config import vessel as config

REVOLT = config.load(config.find("revolt")).thrusters  # two stern azimuths, bow fixed athwart


@pytest.mark.parametrize(
    ("failed", "lost"),
    [
        ((), ()),
        ((0,), ()),
        ((2,), ()),
        ((0, 2), ()),
        ((0, 1), ("way ahead",)),
        ((0, 1, 2), ("thrust",)),
    ],
)
def test_lost_motions(failed: tuple[int, ...], lost: tuple[str, ...]) -> None:
    assert lost_motions(REVOLT, failed) == lost


@pytest.mark.parametrize(
    ("boat", "failed", "straight"),
    [
        ("otter", (), True),
        ("otter", (0,), False),
        ("otter", (1,), False),
        ("otter", (0, 1), True),  # nothing pushes: `lost_motions` says so
        ("revolt", (0,), True),  # an azimuth thruster is left
        ("revolt", (0, 1), True),  # the bow thruster does not push ahead
        ("aboat", (0,), True),
    ],
)
def test_one_fixed_thruster_aside_drives_in_circles(boat: str, failed: tuple[int, ...], straight: bool) -> None:
    assert keeps_straight(config.load(config.find(boat)).thrusters, failed) is straight


def test_a_bow_thruster_keeps_a_boat_with_one_stern_thruster_straight() -> None:
    bow = REVOLT[2]
    port, starboard = config.load(config.find("otter")).thrusters
    assert keeps_straight((port, starboard, bow), {0}) and not keeps_straight((port, starboard, bow), {0, 2})


def test_a_single_screw_on_the_centre_line_does_not_steer() -> None:
    from dataclasses import replace

    screw = replace(REVOLT[0], kind="fixed", y_m=0.0, azimuth_rad=0.0)
    bow = REVOLT[2]
    assert lost_motions((screw, bow), {1}) == ("steering",)
    assert lost_motions((screw, bow), {0}) == ("way ahead",)
