"""Steps that a boat cannot have made."""

from __future__ import annotations

from companion.nav.integrity.continuity import Continuity


def fed(steps: list[tuple[float, float]], dt_s: float = 0.1) -> Continuity:
    track = Continuity()
    for k, (north, east) in enumerate(steps):
        track.take(k * dt_s, north, east, 0.5)
    return track


def test_noise_is_no_step() -> None:
    assert not fed([(0.4, 0.2), (-0.3, 0.3)] * 20).suspect


def test_a_step_that_lasts_is_a_jump() -> None:
    steps = [(0.0, 0.0)] * 5 + [(3.0, 4.0)]
    assert fed(steps).suspect and not fed(steps).jumped
    lasting = fed(steps + [(0.1, 0.0)] * 5)
    assert lasting.jumped and lasting.size == 5.0 and lasting.since_s == 0.5


def test_an_outlier_is_none() -> None:
    track = fed([(0.0, 0.0)] * 5 + [(3.0, 4.0), (-3.0, -4.0)] + [(0.0, 0.0)] * 5)
    assert not track.suspect and not track.jumped


def test_an_outlier_that_goes_back_in_steps_of_noise_is_none() -> None:
    track = fed([(0.0, 0.0)] * 5 + [(0.0, 0.6), (0.0, -0.3), (0.0, -0.3)] + [(0.0, 0.0)] * 5)
    assert not track.suspect and not track.jumped


def test_scattered_outliers_are_no_steady_jump_at_first() -> None:
    scattered = [(5.0, 0.0), (-9.0, 3.0), (12.0, -2.0), (1.0, 7.0)]
    assert not fed(scattered * 2).jumped
    assert fed(scattered * 8).jumped  # for three seconds


def test_agreement_for_a_second_ends_it() -> None:
    track = fed([(5.0, 0.0)] + [(0.0, 0.0)] * 5)
    for k in range(9):
        track.compare(1.0 + 0.1 * k, 0.2, 0.5)
    assert track.suspect
    track.compare(1.95, 0.9, 0.5)  # once not: the second begins anew
    for k in range(12):
        track.compare(2.0 + 0.1 * k, 0.2, 0.5)
    assert not track.suspect


def test_after_a_gap_the_place_counts() -> None:
    track = fed([(5.0, 0.0)])
    track.place(10.0, 0.3, 0.0, 0.5)
    assert not track.suspect
    track.place(20.0, 3.0, 0.0, 0.5)
    assert track.suspect and track.since_s == 20.0
    track.clear()
    assert not track.suspect and track.size == 0.0


def test_an_outlier_that_came_in_a_step_of_noise_is_none() -> None:
    """One side of it just under the bound, the other just over it."""
    track = fed([(0.0, 0.0)] * 5 + [(0.0, -0.4), (0.0, 0.6), (0.0, -0.2)] + [(0.0, 0.0)] * 5)
    assert not track.suspect and not track.jumped


def test_an_outlier_may_go_back_by_a_step_that_is_excused() -> None:
    track = fed([(0.0, 0.0)] * 5 + [(3.0, 4.0)])
    track.take(0.6, -3.0, -4.0, 0.5, excused=True)
    assert not track.suspect


def test_an_excused_step_begins_no_suspicion_and_adds_to_none() -> None:
    track = fed([(0.0, 0.0)] * 5)
    track.take(0.5, 3.0, 4.0, 0.5, excused=True)
    assert not track.suspect
    track.take(0.6, -3.0, -4.0, 0.5)  # and back, which alone would be a jump
    track.take(0.7, 0.0, 0.0, 0.5)
    assert not track.suspect
    jumped = fed([(0.0, 0.0)] * 5 + [(3.0, 4.0)])
    jumped.take(0.6, 3.0, 4.0, 0.5, excused=True)
    assert jumped.size == 5.0
