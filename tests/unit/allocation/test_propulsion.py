"""What failed thrusters leave the boat able to do, and what the supervisor makes of it."""

from __future__ import annotations

import pytest

from companion.allocation.propulsion import lost_motions
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


def test_a_single_screw_on_the_centre_line_does_not_steer() -> None:
    from dataclasses import replace

    screw = replace(REVOLT[0], kind="fixed", y_m=0.0, azimuth_rad=0.0)
    bow = REVOLT[2]
    assert lost_motions((screw, bow), {1}) == ("steering",)
    assert lost_motions((screw, bow), {0}) == ("way ahead",)
