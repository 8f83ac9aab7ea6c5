"""A design's runs: how many, each once, in which order; samples that come again."""

import itertools
import math
import shlex
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.cli.main import argument_parser
from companion.config.vessel import find
from sitl.scenarios import SCENARIOS
from sitl.sweep.design import DesignConfig, PartConfig, RangeConfig
from sitl.sweep.plan import Run, contents_of, key_of, runs_of, sampled

names = st.lists(st.sampled_from(sorted(SCENARIOS)), min_size=1, max_size=4, unique=True)
boats = st.lists(st.sampled_from(["revolt", "aboat", "otter"]), max_size=3, unique=True)
levels = st.dictionaries(
    st.sampled_from(["wind", "waves", "law"]), st.lists(st.integers(0, 9), min_size=1, max_size=3, unique=True)
)
parts = st.builds(
    lambda scenarios, vessels, chosen, seeds, samples: PartConfig(
        tuple(scenarios), tuple(vessels), seeds, None, {}, {k: tuple(v) for k, v in chosen.items()},
        {"current": RangeConfig(0.0, 1.0, 12)} if samples else {}, "latin_hypercube", samples,
    ),
    names, boats, levels, st.integers(1, 4), st.none() | st.integers(1, 5),
)  # fmt: skip


def count(part: PartConfig) -> int:
    crossed = math.prod(len(values) for values in part.levels.values())
    return len(part.scenarios) * max(1, len(part.vessels)) * crossed * (part.samples or 1) * (part.seeds or 1)


def design(*of: PartConfig, seeds: int = 1) -> DesignConfig:
    return DesignConfig("night", of, seeds=seeds)


@given(parts)
def test_a_part_has_every_combination_once(part: PartConfig) -> None:
    runs = runs_of(design(part), SCENARIOS)
    assert len(runs) == count(part)
    assert len({key_of(run) for run in runs}) == len(runs)


@given(st.lists(parts, min_size=1, max_size=3))
def test_what_two_parts_ask_for_is_sailed_once(several: list[PartConfig]) -> None:
    runs = runs_of(design(*several), SCENARIOS)
    assert len(set(runs)) == len(runs)
    assert set(runs) == {run for part in several for run in runs_of(design(part), SCENARIOS)}


@given(parts)
def test_a_part_that_is_cut_off_has_as_many_of_each_point(part: PartConfig) -> None:
    runs = runs_of(design(part), SCENARIOS)
    for cut in range(1, len(runs)):
        begun = [(run.scenario, run.vessel, run.settings) for run in runs[:cut]]
        of_each = [begun.count(point) for point in {(run.scenario, run.vessel, run.settings) for run in runs}]
        assert max(of_each) - min(of_each) <= 1


def test_more_seeds_keep_the_runs_that_there_were() -> None:
    part = PartConfig(("hold",), levels={"wind": ("2", "4")})
    few, many = runs_of(design(part, seeds=2), SCENARIOS), runs_of(design(part, seeds=5), SCENARIOS)
    assert {key_of(run) for run in few} < {key_of(run) for run in many}


def test_a_factor_fills_the_braces_of_a_setting() -> None:
    part = PartConfig(
        ("hold",),
        settings={"wind": "{speed}@{side}", "waves": 0.5},
        levels={"side": (0, 90), "speed": (2.5,), "gnss": ("rtk",)},
    )
    runs = runs_of(design(part), SCENARIOS)
    assert [dict(run.settings) for run in runs] == [
        {"gnss": "rtk", "waves": "0.5", "wind": "2.5@0"},
        {"gnss": "rtk", "waves": "0.5", "wind": "2.5@90"},
    ]
    assert runs[0].point == "hold revolt waves=0.5 side=0 speed=2.5 gnss=rtk"


def test_samples_of_a_point_have_its_name_and_their_factors() -> None:
    part = PartConfig(("hold",), ranges={"wind": RangeConfig(0.0, 6.0, 1)}, samples=4)
    runs = runs_of(design(part), SCENARIOS)
    assert {run.point for run in runs} == {"hold revolt"}
    assert [dict(run.settings)["wind"] for run in runs] == [f"{run.factors['wind']:g}" for run in runs]


def test_a_sample_is_sailed_with_all_levels_before_the_next() -> None:
    part = PartConfig(("hold",), levels={"gnss": ("rtk", "sbas")}, ranges={"wind": RangeConfig(0.0, 6.0)}, samples=3)
    runs = runs_of(design(part), SCENARIOS)
    assert [dict(run.settings)["gnss"] for run in runs] == ["rtk", "sbas"] * 3
    assert all(a.factors == b.factors for a, b in zip(runs[::2], runs[1::2], strict=True))


@pytest.mark.parametrize("sampling", ["latin_hypercube", "sobol"])
def test_the_same_seed_gives_the_same_samples(sampling: str) -> None:
    def of(seed: int) -> list[dict[str, float]]:
        ranges = {"wind": RangeConfig(0.0, 8.0), "waves": RangeConfig(-1.0, 1.0)}
        return sampled(PartConfig(("hold",), ranges=ranges, sampling=sampling, samples=16, sampling_seed=seed))  # type: ignore[arg-type]

    assert of(1) == of(1) != of(2)
    assert all(0.0 <= row["wind"] <= 8.0 and -1.0 <= row["waves"] <= 1.0 for row in of(1))


@pytest.mark.parametrize("sampling", ["latin_hypercube", "sobol"])
def test_every_sixteenth_of_a_range_has_one_of_sixteen_samples(sampling: str) -> None:
    ranges = {"wind": RangeConfig(0.0, 16.0, 9), "waves": RangeConfig(0.0, 16.0, 9)}
    rows = sampled(PartConfig(("hold",), ranges=ranges, sampling=sampling, samples=16))  # type: ignore[arg-type]
    for name in ranges:
        assert sorted(int(row[name]) for row in rows) == list(range(16))


def test_a_value_is_what_a_person_can_type() -> None:
    ranges = {"wind": RangeConfig(0.0, 8.0, 1)}
    rows = sampled(PartConfig(("hold",), ranges=ranges, samples=32))
    assert all(len(f"{row['wind']:.12g}") <= len("0.0") for row in rows)


def test_the_command_of_a_run_repeats_it() -> None:
    run = Run("hold", "revolt", 7, (("waves", "0.5"), ("wind", "2@45")))
    program, *words = shlex.split(run.command)
    asked = argument_parser().parse_args(words)
    assert (program, asked.name, asked.vessel, asked.seed) == ("companion", "hold", "revolt", 7)
    assert asked.changes == ["waves=0.5", "wind=2@45"]


def test_each_part_of_a_run_counts_in_its_key(tmp_path: Path) -> None:
    text = find("revolt").read_text(encoding="utf-8")
    one, other = tmp_path / "a.toml", tmp_path / "b.toml"
    one.write_text(text, encoding="utf-8")
    other.write_text(text + "\n", encoding="utf-8")
    runs = [
        Run("hold", "revolt", 0), Run("route", "revolt", 0), Run("hold", "otter", 0), Run("hold", "revolt", 1),
        Run("hold", "revolt", 0, (("wind", "2"),)), Run("hold", str(one), 0), Run("hold", str(other), 0),
    ]  # fmt: skip
    assert all(key_of(a) != key_of(b) for a, b in itertools.combinations(runs, 2))


def test_an_overlay_that_is_accepted_makes_it_another_boat(tmp_path: Path) -> None:
    boat, overlay = tmp_path / "boat.toml", tmp_path / "boat.trial-2026-11-22.toml"
    boat.write_bytes(find("revolt").read_bytes())
    run, keys = Run("hold", str(boat), 0), []
    for text in (None, "accepted = false", "accepted = true"):
        if text is not None:
            overlay.write_text(f"[trial]\n{text}\n[hull]\nm11_kg = 300.0\n", encoding="utf-8")
        contents_of.cache_clear()  # a process asks once
        keys.append(key_of(run))
    assert keys[0] == keys[1] != keys[2]
