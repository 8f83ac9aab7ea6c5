"""A rudder in a vessel's file: what is filled in, what is refused, and what the boat says that it cannot do."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.allocation.rudder_curve import RudderCurve
from companion.cli.drawing import characters, svg
from companion.cli.new_file import file_text
from companion.config.plausibility import judgements
from companion.config.reversing import turns_on_the_spot
from companion.config.vessel import ConfigError, parse
from tests.unit.rudder_boat import ANSWERS, SKIFF, TEXT, beside

BLADE = "manual_azimuth_deg = 35.0\n"


def test_the_blade_follows_from_the_boat() -> None:
    (thruster,) = SKIFF.thrusters
    assert thruster.rudder is not None and thruster.propeller_m is not None
    assert thruster.rudder.span_m >= 1.1 * thruster.propeller_m - 1e-3
    assert thruster.rudder.aspect == pytest.approx(1.5, rel=0.02)
    assert thruster.rudder.x_m == pytest.approx(thruster.x_m - 0.6 * thruster.propeller_m, abs=1e-3)
    assert thruster.azimuth_max_rad == pytest.approx(math.radians(35.0))
    assert SKIFF.limits.sway_n == 0.0 and SKIFF.limits.yaw_nm > 0.0


def test_what_was_measured_stays() -> None:
    boat = parse(TEXT.replace(BLADE, f"{BLADE}[thruster.rudder]\nspan_m = 0.3\nx_m = -1.1\n"), "boat.toml")
    rudder = boat.thrusters[0].rudder
    assert rudder is not None and (rudder.span_m, rudder.x_m) == (0.3, -1.1)
    assert rudder.chord_m == pytest.approx(0.2) and rudder.race_share < 0.6


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("azimuth_max_deg = 35.0", "azimuth_max_deg = 80.0", "needs stops either side of amidships"),
        ("y_m = 0 ", "y_m = 0.2 ", "lies in the middle of the boat"),
        (BLADE, f"{BLADE}[thruster.rudder]\nx_m = 0.5\n", "rudder.x_m: a rudder is at the stern"),
        (BLADE, f"{BLADE}[thruster.rudder]\nx_m = -0.5\n", "race_share should be 0"),
        (BLADE, f"{BLADE}[thruster.rudder]\nspan_m = 2.0\nchord_m = 0.1\n", "20 times as high as wide"),
        (BLADE, f"{BLADE}propeller_m = 0.05\n[thruster.rudder]\nspan_m = 0.2\nrace_share = 1.0\n", "times the thrust"),
        (BLADE, f"{BLADE}[thruster.rudder]\nheight_m = 0.2\n", "rudder.height_m"),
        ("[hull]", "[limits]\nsurge_n = 70\nsway_n = 5\nyaw_nm = 10\n[hull]", "cannot push a boat at rest sideways"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_with_its_place(old: str, new: str, said: str) -> None:
    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    with pytest.raises(ConfigError, match=said):
        parse(text, "boat.toml")


def test_a_blade_is_for_a_rudder_only() -> None:
    blade = "[thruster.rudder]\nspan_m = 0.2\nchord_m = 0.1\nx_m = -1.0\nrace_share = 1.0\n"
    text = TEXT.replace('kind = "rudder"', 'kind = "azimuth"').replace(BLADE, BLADE + blade)
    with pytest.raises(ConfigError, match="rudder: only for a thruster of kind 'rudder' or 'sail', not 'azimuth'"):
        parse(text, "boat.toml")


def test_two_rudders_share_the_area_and_steer_with_differential_thrust() -> None:
    (alone,) = SKIFF.thrusters
    both = parse(file_text(replace(ANSWERS, layout="two-rudders", spread_m=0.3)), "boat.toml")
    assert alone.rudder is not None
    assert not both.has_rudder and SKIFF.has_rudder
    assert [t.y_m for t in both.thrusters] == [-0.15, 0.15]
    assert all(t.rudder is not None and t.rudder.area_m2 <= alone.rudder.area_m2 for t in both.thrusters)
    assert both.limits.sway_n == 0.0
    between_nm = 0.9 * 0.15 * 2.0 * -both.thrusters[0].min_n  # by differential thrust alone
    assert both.limits.yaw_nm > between_nm
    assert turns_on_the_spot(both.thrusters) and not turns_on_the_spot(SKIFF.thrusters)


@pytest.mark.parametrize(("stern_m", "pushes_sideways"), [(None, False), (-0.7, True)])
def test_side_thrusters_beside_a_rudder_push_the_boat_sideways(stern_m: float | None, pushes_sideways: bool) -> None:
    more = {} if stern_m is None else {"stern": (stern_m, 20.0)}
    boat = parse(beside(TEXT, bow=(0.7, 20.0), **more), "boat.toml")
    assert (boat.limits.sway_n > 0.0) == pushes_sideways
    lever_m, most_n, astern_n = 0.7, 20.0, -boat.thrusters[1].min_n
    turning_nm = 2.0 * lever_m * astern_n if pushes_sideways else lever_m * most_n
    assert pushes_sideways or 0.35 * SKIFF.limits.yaw_nm < 0.9 * turning_nm
    assert boat.limits.yaw_nm == pytest.approx(0.9 * turning_nm, rel=1e-3)


def test_a_weak_bow_thruster_leaves_the_boat_the_moment_of_its_rudder() -> None:
    boat = parse(file_text(replace(ANSWERS, layout="rudder-bow", bow_motor="1")), "boat.toml")
    assert boat.limits.yaw_nm == pytest.approx(0.35 * SKIFF.limits.yaw_nm, rel=0.1)


def test_a_turning_thruster_beside_a_rudder_is_refused() -> None:
    row = TEXT[TEXT.index("[[thruster]]") : TEXT.index("[[sensor]]")]
    other = row.replace('"propeller"', '"pod"').replace('kind = "rudder"', 'kind = "azimuth"')
    two = TEXT.replace(row, row + other).replace('["propeller"]', '["propeller", "pod"]')
    with pytest.raises(ConfigError, match=r"thruster.1..kind: .* others and fixed thrusters: 'pod' is neither"):
        parse(two, "boat.toml")


def test_check_says_what_it_cannot_do_and_draw_shows_the_blade() -> None:
    said = [str(found) for found in judgements(SKIFF)]
    assert any("Dock: refused" in text for text in said)
    assert "rudder of propeller" in characters(SKIFF) and ">rudder 0.1" in svg(SKIFF)


def test_the_yaw_limit_is_what_the_blade_gives_with_full_thrust() -> None:
    """Not what it gives with the boat at rest on the spot: under way, that would be a third of the blade."""
    thruster = SKIFF.thrusters[0]
    curve = RudderCurve(thruster)
    assert thruster.azimuth_max_rad is not None
    _, side_n = curve.force_n(thruster.max_n, thruster.azimuth_max_rad, 0.0)
    assert SKIFF.limits.yaw_nm == pytest.approx(0.9 * abs(curve.lever_m) * side_n, rel=0.02)


def test_defaults_of_a_boat_that_turns_in_a_circle() -> None:
    p = SKIFF.parameters
    radius_m = p["WP_SPEED"] / math.radians(p["PATH_YAW_RATE"])
    assert 1.5 * SKIFF.length_m < radius_m < 2.5 * SKIFF.length_m  # a turning circle in the range of IMO MSC.137(76)
    assert p["NAV_ACC_RAD"] >= radius_m
    # its watch circle stays inside the fence, with its ends
    assert p["FENCE_MARGIN"] == p["DP_WATCH_R"] + 0.5 * SKIFF.length_m
