"""A design's file: what it may say, and every mistake with its place and remedy."""

import pytest

from companion.config.vessel import ConfigError
from sitl.scenarios import SCENARIOS
from sitl.sweep.design import DesignConfig, parse_design

GOOD = """
name = "night"
seeds = 10
[[part]]
scenarios = ["hold"]
set = { wind = "{speed}@45" }
levels = { gnss = ["rtk", "sbas"] }
range.speed = { low = 0, high = 6, digits = 1 }
sampling = "sobol"
samples = 4
"""


def parse(text: str) -> DesignConfig:
    return parse_design(text, "night.toml", SCENARIOS)


def problems(text: str) -> tuple[str, ...]:
    with pytest.raises(ConfigError) as refused:
        parse(text)
    return refused.value.problems


def test_a_design_is_read() -> None:
    design = parse(GOOD)
    (part,) = design.parts
    assert (design.name, design.seeds, design.minutes) == ("night", 10, None)
    assert (part.samples, part.sampling, part.ranges["speed"].high) == (4, "sobol", 6.0)


@pytest.mark.parametrize(
    ("before", "after", "place", "said"),
    [
        ('"hold"', '"hodl"', ":5: part[1].scenarios", "did you mean 'hold'?"),
        ('"hold"', '"hold", "hold"', ":5: part[1].scenarios", "'hold' stands there twice"),
        ("seeds = 10", "sedes = 10", ":3: sedes", "did you mean 'seeds'?"),
        ("seeds = 10", "seeds = 0", ":3: seeds", "greater than or equal to 1"),
        ('["hold"]', '["hold"]\nvessels = ["revlot"]', ":6: part[1].vessels", "did you mean 'revolt'?"),
        ('["hold"]', '["hold"]\nvessels = ["rescuerunner"]', ":5: part[1].scenarios", "it needs sideways thrust"),
        ("set = { wind", "set = { wnid", ":6: part[1].set.wnid", "did you mean 'wind'?"),
        ("{speed}@45", "{sped}@45", ":6: part[1].set.wind", "no factor 'sped' in levels or range; did you mean 'speed'?"),
        ("{speed}@45", "{speed@45", ":6: part[1].set.wind", "write a factor as {name}"),
        ("{speed}@45", "{speed:.1f}@45", ":6: part[1].set.wind", "braces hold more than a name"),
        ('{speed}@45" }', '{speed}@45", gnss = "rtk" }', ":6: part[1].set.gnss", "is a factor in levels too"),
        ('["rtk", "sbas"]', '["rtk", "rtk"]', ":7: part[1].levels.gnss", "'rtk' stands there twice"),
        ('["rtk", "sbas"]', "[]", ":7: part[1].levels.gnss", "needs at least one value"),
        ("levels = { gnss", "levels = { speed", ":8: part[1].range.speed", "stands in levels too"),
        ("levels = { gnss", "levels = { gns", ":7: part[1].levels.gns", "no setting has {gns}"),
        ("low = 0", "low = 0.25", ":8: part[1].range.speed.low", "0.25 has more decimals than digits = 1"),
        ("high = 6", "high = 6.02", ":8: part[1].range.speed.high", "6.02 has more decimals than digits = 1"),
        ("high = 6", "high = 0", ":8: part[1].range.speed", "0 is not above low = 0"),
        ("samples = 4", "samples = 5", ":10: part[1].samples", "take 4 or 8"),
        ("samples = 4", "", ":4: part[1].samples", "is missing"),
        ("range.speed = { low = 0, high = 6, digits = 1 }", "", ":10: part[1].samples", "there is no range to sample"),
        ('"sobol"', '"sobel"', ":9: part[1].sampling", "should be 'latin_hypercube' or 'sobol'"),
        ("samples = 4", "samples = ", ":10: not valid TOML", "the value is missing"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_with_its_place_and_remedy(before: str, after: str, place: str, said: str) -> None:
    assert before in GOOD
    found = problems(GOOD.replace(before, after, 1))
    assert [problem for problem in found if problem.startswith(f"night.toml{place}") and said in problem], found


def test_every_mistake_is_told_at_once() -> None:
    found = problems(
        GOOD.replace('"hold"', '"hodl"').replace("samples = 4", "samples = 5").replace("high = 6", "high = -1")
    )
    assert len(found) == 3


def test_a_leader_that_is_too_fast_for_a_boat_is_refused() -> None:
    text = 'name = "a"\n[[part]]\nscenarios = ["follow"]\nvessels = ["revolt"]\nset = { leader = "straight@9" }\n'
    assert "its leader sails 9 m/s" in problems(text)[0]


def test_boats_refused_for_one_reason_are_named_in_one_line() -> None:
    text = 'name = "a"\n[[part]]\nscenarios = ["hold"]\nvessels = ["otter", "revolt", "heron"]\n'
    (found,) = problems(text)
    assert "hold is not for otter, heron: it needs sideways thrust" in found


def test_what_a_scenario_refuses_by_its_own_settings_is_said_before_the_first_run() -> None:
    """A sweep of a night ended at the first boat without a magnetometer."""
    part = 'name = "a"\n[[part]]\nscenarios = ["ahrs"]\nvessels = ["revolt", "{}"]\n'
    assert parse(part.format("aboat")).parts[0].vessels == ("revolt", "aboat")
    levels = 'levels = { magnetometer = ["calibrated", "raw"] }\n'
    for text in (part.format("blueboat"), part.format("blueboat") + levels):
        assert "ahrs is not for blueboat: it needs a magnetometer" in problems(text)[0]
