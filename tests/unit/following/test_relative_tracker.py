"""Where the leader is relative to the boat: which way is used, what it is worth, and which vectors are not believed."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest

from companion.app import load_vessel
from companion.config.vessel import VesselConfig
from companion.core.decision import TextKind
from companion.core.estimate import Leader, RelativeBy
from companion.core.geodesy import LocalFrame
from companion.core.readings import FixType, GnssFix, RelativeFix
from companion.following.relative_tracker import RelativeTracker
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST
from tests.unit.following.leaders import leader_at

DT_S = 0.05
FRAME = LocalFrame(57.63, 11.55)


class Sea:
    """The boat lies at the origin; the leader lies 20 m north of it and its messages place it `off_m` (north) wrong,
    and the boat's receiver errs by `own_m`. `sail` ticks; every second the moving base gives `vector` as the leader
    sees the boat, where `base` is set."""

    def __init__(self, config: VesselConfig) -> None:
        self.said: list[str] = []
        self.parameters = Parameters()
        self.parameters.set("FOLL_COMMON", 0.8)
        self.tracker = RelativeTracker(config, self.parameters, self._say)
        self.now_s = 100.0
        self.off_m, self.own_m = 0.0, 0.0
        self.leader_fix: FixType | None = FixType.FIX_3D
        self.fix = FixType.FIX_3D
        self.north_mps = 0.0
        self.north_m = 20.0
        self.base: FixType | None = None
        self.base_off_m = 0.0
        self.frozen: RelativeFix | None = None
        self.ticks = 0

    def _say(self, now_s: float, kind: TextKind, name: str, text: str) -> None:
        assert len(text) <= 50
        self.said.append(text)

    def sail(self, duration_s: float) -> Leader:
        for _ in range(round(duration_s / DT_S)):
            self.now_s += DT_S
            self.ticks += 1
            self.north_m += self.north_mps * DT_S
            reported = leader_at(self.north_m + self.off_m, 0.0, speed_mps=abs(self.north_mps))
            reported = replace(reported, north_mps=self.north_mps, accuracy_m=1.2)
            nav = replace(AT_REST, t_s=self.now_s, north_m=self.own_m, position_accuracy_m=1.2, position_age_s=0.0)
            if self.ticks % 2 == 0:
                self.tracker.take(self.own_fix())
            if self.base is not None and self.ticks % 20 == 0:
                self.tracker.take(self.vector())
            self.tracker.update(reported, self.leader_fix, nav, FRAME, self.now_s)
            self.leader = self.tracker.placed(reported)
        return self.leader

    def own_fix(self) -> GnssFix:
        lat_deg, lon_deg = FRAME.to_geodetic(self.own_m, 0.0)
        return GnssFix(self.now_s, "gnss", lat_deg, lon_deg, None, self.fix, 11, 1.1, 1.2)

    def vector(self) -> RelativeFix:
        if self.frozen is not None:
            return replace(self.frozen, t_s=self.now_s)
        north_m = -(self.north_m + self.base_off_m) + 0.001 * (self.ticks % 7)
        return RelativeFix(self.now_s, "gnss", north_m, 0.0, 0.0, self.base or FixType.NONE, 0.01)

    @property
    def gap_m(self) -> float:
        return self.leader.north_m - self.own_m


@pytest.fixture
def sea() -> Sea:
    return Sea(load_vessel("rescuerunner"))


def test_like_receivers_are_compared_with_each_other(sea: Sea) -> None:
    """Both err alike: the estimate of the boat, which rests on another receiver, does not."""
    sea.off_m = sea.own_m = 5.0
    leader = sea.sail(10.0)
    assert leader.relative_by is RelativeBy.DIFFERENCE and sea.gap_m == pytest.approx(20.0, abs=0.01)
    assert 0.4 < leader.relative_m < 0.85


def test_other_kinds_of_fix_are_not_compared(sea: Sea) -> None:
    sea.fix = FixType.RTK_FIXED
    leader = sea.sail(5.0)
    assert leader.relative_by is RelativeBy.POSITIONS and leader.north_m == 20.0
    assert leader.relative_m == pytest.approx(math.hypot(1.2, 1.2))
    sea.fix, sea.leader_fix = FixType.FIX_3D, None
    assert sea.sail(5.0).relative_by is RelativeBy.POSITIONS


def test_a_moving_base_is_better_and_its_loss_is_told(sea: Sea) -> None:
    sea.off_m, sea.base = 2.0, FixType.RTK_FIXED
    leader = sea.sail(20.0)
    assert leader.relative_by is RelativeBy.MOVING_BASE and sea.gap_m == pytest.approx(20.0, abs=0.1)
    assert leader.relative_m < 0.1
    sea.base = None
    leader = sea.sail(5.0)
    assert leader.relative_by is RelativeBy.DIFFERENCE and sea.gap_m == pytest.approx(20.0, abs=0.3)
    assert 0.05 < leader.relative_m < 0.5
    sea.leader_fix = None
    leader = sea.sail(20.0)
    assert leader.relative_by is RelativeBy.POSITIONS and sea.gap_m == pytest.approx(22.0, abs=0.1)


def test_a_float_solution_weighs_less(sea: Sea) -> None:
    sea.base = FixType.RTK_FLOAT
    assert sea.sail(5.0).relative_m > 0.07


def test_the_leaders_place_moves_smoothly_to_a_better_one(sea: Sea) -> None:
    sea.off_m = 3.0
    sea.sail(10.0)
    sea.base = FixType.RTK_FIXED
    gaps = []
    for _ in range(200):
        sea.sail(DT_S)
        gaps.append(sea.gap_m)
    assert max(abs(b - a) for a, b in itertools.pairwise(gaps)) <= 0.5 * DT_S + 1e-6
    assert gaps[-1] == pytest.approx(20.0, abs=0.1)


def test_the_parameter_forbids_ways(sea: Sea) -> None:
    sea.base = FixType.RTK_FIXED
    sea.parameters.set("FOLL_REL", 1.0)
    assert sea.sail(5.0).relative_by is RelativeBy.DIFFERENCE
    sea.parameters.set("FOLL_REL", 0.0)
    assert sea.sail(5.0).relative_by is RelativeBy.POSITIONS


def test_what_two_receivers_share_makes_the_difference_better(sea: Sea) -> None:
    sea.parameters.set("FOLL_COMMON", 0.6)
    little = sea.sail(5.0).relative_m
    sea.parameters.set("FOLL_COMMON", 0.95)
    assert sea.sail(5.0).relative_m < 0.6 * little


def test_where_that_is_not_known_positions_are_as_good(sea: Sea) -> None:
    sea.parameters.set("FOLL_COMMON", 0.0)
    sea.off_m = 2.0
    assert sea.sail(20.0).relative_by is RelativeBy.POSITIONS and sea.gap_m == 22.0


# --- vectors that are not true -------------------------------------------------------------------------------------


def test_a_jump_is_ignored_until_it_has_been_steady(sea: Sea) -> None:
    sea.base = FixType.RTK_FIXED
    sea.sail(20.0)
    sea.base_off_m = 3.0
    leader = sea.sail(10.0)
    assert leader.relative_by is RelativeBy.DIFFERENCE and sea.gap_m == pytest.approx(20.0, abs=0.3)
    assert sea.said == ["Relative position ignored: jumped 3.0 m"] and sea.tracker.doubt
    sea.base_off_m = 0.0
    assert sea.sail(10.0).relative_by is RelativeBy.DIFFERENCE
    assert sea.sail(30.0).relative_by is RelativeBy.MOVING_BASE
    assert sea.said[1:] == ["Relative position is used again"] and not sea.tracker.doubt


def test_far_off_both_positions_it_never_counts(sea: Sea) -> None:
    sea.base, sea.base_off_m = FixType.RTK_FIXED, 9.0
    leader = sea.sail(60.0)
    assert leader.relative_by is RelativeBy.DIFFERENCE and sea.gap_m == pytest.approx(20.0, abs=0.1)
    assert sea.said == ["Relative position ignored: 9.0 m off positions"]


def test_one_that_repeats_itself_is_found_at_once(sea: Sea) -> None:
    sea.base = FixType.RTK_FIXED
    sea.sail(20.0)
    sea.frozen = sea.vector()
    leader = sea.sail(5.0)
    assert leader.relative_by is RelativeBy.DIFFERENCE
    assert sea.said == ["Relative position ignored: it repeats itself"]


def test_one_that_stands_still_while_the_leader_goes_is_found(sea: Sea) -> None:
    """Not the same to the last digit, but where it was."""
    sea.base = FixType.RTK_FIXED
    sea.sail(20.0)
    sea.north_mps = 1.0
    for _ in range(6):
        sea.base_off_m = 20.0 - sea.north_m - 1.0
        sea.sail(1.0)
    assert sea.leader.relative_by is RelativeBy.DIFFERENCE and sea.gap_m == pytest.approx(26.0, abs=0.8)


def test_one_that_creeps_away_is_found_by_the_receivers(sea: Sea) -> None:
    """Slower than the velocities tell, until it is five sigmas of the receivers' difference away."""
    sea.base = FixType.RTK_FIXED
    sea.sail(20.0)
    for _ in range(120):
        sea.base_off_m += 0.06
        sea.sail(1.0)
        if sea.tracker.doubt:
            break
    assert sea.tracker.doubt.endswith("m off positions") and sea.base_off_m < 6.5


def test_a_single_wrong_difference_changes_nothing(sea: Sea) -> None:
    sea.sail(20.0)
    sea.off_m = 60.0
    sea.sail(DT_S)
    sea.off_m = 0.0
    sea.sail(1.0)
    assert sea.gap_m == pytest.approx(20.0, abs=0.1)


def test_another_leader_begins_anew(sea: Sea) -> None:
    sea.base, sea.off_m = FixType.RTK_FIXED, 2.0
    sea.sail(20.0)
    other = replace(leader_at(50.0), system_id=9)
    sea.tracker.update(other, FixType.FIX_3D, replace(AT_REST, t_s=sea.now_s), FRAME, sea.now_s)
    assert sea.tracker.placed(other).north_m == 50.0


def test_old_positions_are_followed_as_they_are(sea: Sea) -> None:
    sea.base, sea.off_m = FixType.RTK_FIXED, 2.0
    sea.sail(20.0)
    late = replace(leader_at(22.0), age_s=1.5)
    sea.tracker.update(late, FixType.FIX_3D, replace(AT_REST, t_s=sea.now_s), FRAME, sea.now_s)
    assert sea.tracker.placed(late).relative_by is RelativeBy.POSITIONS
