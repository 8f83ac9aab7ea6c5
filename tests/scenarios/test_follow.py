"""Following a lead boat, whole: its module's bytes, the follower's sensors and jet, judged by the truth of both
boats."""

from __future__ import annotations

import csv
import math
import re
import statistics
from collections.abc import Mapping
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.cli.rig import LockstepRig
from companion.config.vessel import ConfigError, find
from sitl.emulators.gnss import GnssEmulator
from sitl.scenarios import SCENARIOS
from sitl.scenarios.follow_measure import Chase
from sitl.scenarios.measure import read_events, read_truth
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import ScenarioError, run

SEEDS = 16
FIRST_TEST = {"law": "thesis", "plant": "as_sailed", "gap": "20", "gains": "1.2/1.5"}
LEAST_THAT_SWING = 12  # of 16 seeds; a boat that meets its turns gently enough never begins
SECOND_TEST = {"law": "thesis", "plant": "as_sailed", "gap": "45", "gains": "1.0/1.2"}


def sail(
    name: str, folder: Path, seed: int, must_hold: bool = True, vessel: str | None = None, **changes: str
) -> Mapping[str, float]:
    outcome = run(SCENARIOS[name], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    assert outcome.error is None, outcome.error
    assert outcome.ok or not must_hold, [check.row() for check in outcome.checks if not check.ok]
    return outcome.metrics


def over_seeds(folder: Path, must_hold: bool = True, **changes: str) -> list[Mapping[str, float]]:
    return [sail("follow", folder / str(seed), seed, must_hold, **changes) for seed in range(SEEDS)]


def slow_nozzle(folder: Path) -> str:
    """The RescueRunner with its linear actuator, and a file that says so."""
    text = find("rescuerunner").read_text(encoding="utf-8")
    for line, other in (
        ("azimuth_rate_dps = 70.0", "azimuth_rate_dps = 14.0"),
        ('plant = "as_estimated"', 'plant = "as_sailed"'),
    ):
        assert text.count(line) == 1
        text = text.replace(line, other)
    path = folder / "slow_nozzle.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def pooled_rms(runs: list[Mapping[str, float]], name: str) -> float:
    return math.sqrt(statistics.fmean(run[name] ** 2 for run in runs if not math.isnan(run[name])))


# --- quick: one seed -----------------------------------------------------------------------------------------------


@pytest.mark.sweep
@pytest.mark.parametrize("seed", [2, 3, 4, 100, 101])  # of those whose first turns made it swing
def test_a_nozzle_slower_than_the_file_says_is_found_and_the_boat_follows(tmp_path: Path, seed: int) -> None:
    found = sail("follow", tmp_path, seed, plant="as_sailed")
    assert found["known_in_wake_share"] > 0.98 and found["swing_straight_rms_deg"] < 2.0
    with (tmp_path / "events.csv").open(encoding="utf-8") as file:
        told = [row["text"] for row in csv.DictReader(file) if row["name"] == "turn_rate_jet"]
    assert len(told) == 1 and re.fullmatch(r"Thruster jet turns at 1[2-7] of 70 deg/s", told[0])


@pytest.mark.sweep
def test_in_the_wake_through_a_u_turn(tmp_path: Path) -> None:
    """With receivers good enough for the truth to be judged."""
    metrics = sail("follow", tmp_path, 1, leader="uturn@8.2", gnss="sbas", time="95")
    assert (
        metrics["in_wake_share"] >= 0.98 and metrics["gap_straight_rms_m"] <= 2.0 and metrics["gap_bend_rms_m"] <= 5.0
    )
    assert (tmp_path / "leader.csv").read_text(encoding="utf-8").count("\n") > 95 * 10


def test_up_to_a_leader_at_rest_and_away_with_it(tmp_path: Path) -> None:
    """The lead boat lies with its bow towards the follower, so that the way to its stern leads around it."""
    sail("approach", tmp_path, 1, heading="150", distance="200", wait="75", time="45")


def test_link_and_own_receiver_lost(tmp_path: Path) -> None:
    sail("link_loss", tmp_path, 1, back="35")


def said(folder: Path) -> list[str]:
    return [event.text for event in read_events(folder) if event.name.startswith(("leader_place", "relative"))]


def test_a_moving_base_gives_the_true_gap(tmp_path: Path) -> None:
    """Where both plain receivers say something else by a metre and more."""
    metrics = sail("follow", tmp_path, 1, leader="straight@8.2", base="moving", time="45")
    assert metrics["gap_rms_m"] <= 0.3 and metrics["off_rms_m"] <= 0.5
    assert metrics["receivers_gap_rms_m"] > 1.0
    assert said(tmp_path)[-1] in ("Leader's place by moving base, ±0.0 m", "Leader's place by moving base, ±0.1 m")


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("lie", "text"), [("jumps", "jumped"), ("repeats", "it repeats itself"), ("far", "m off positions"), ("silent", "")]
)
def test_a_moving_base_that_lies_is_not_followed(tmp_path: Path, lie: str, text: str) -> None:
    """From 30 s to the end. What is left is the difference of the receivers."""

    class Lying(LockstepRig):
        def step(self) -> None:
            receiver = next(sensor for sensor in self.world.sensors if isinstance(sensor, GnssEmulator))
            assert receiver.relative is not None
            if self.now_s > 30.0:
                receiver.relative.frozen = lie == "repeats"
                receiver.relative.off_m = {"jumps": (4.0, 4.0), "far": (40.0, 0.0)}.get(lie, (0.0, 0.0))
                receiver.relative.deaf = lie == "silent"
            super().step()

    changes = {"leader": "thesis@8.2", "base": "moving", "common": "0.9", "time": "100"}
    outcome = run(SCENARIOS["follow"], Lying, tmp_path, seed=1, changes=changes)
    assert outcome.error is None, outcome.error
    metrics, texts = outcome.metrics, said(tmp_path)
    assert metrics["gap_rms_m"] <= 2.0 and metrics["in_wake_share"] >= 0.98 and metrics["nearest_m"] >= 12.0
    assert any(one.startswith("Leader's place by difference") for one in texts), texts
    assert not text or any("ignored" in one and text in one for one in texts), texts


@pytest.mark.sweep
def test_round_the_leader_under_way(tmp_path: Path) -> None:
    sail("station_change", tmp_path, 1, each="32")


def test_two_behind_one(tmp_path: Path) -> None:
    sail("two_followers", tmp_path, 1, leader="straight@8.2", time="40")
    assert (tmp_path / "second" / "leader.csv").is_file()


def test_packets_reach_the_vessel_between_its_ticks(tmp_path: Path) -> None:
    """At the time at which they arrive, as on a boat: a leader's delay can be measured in lockstep too."""
    rig = LockstepRig(Conditions("rescuerunner"), tmp_path)
    while rig.now_s < 3.0:
        rig.step()
    codec = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    rig.deliver(mavlink.MAVLink_set_mode_message(1, 1, 0x03040000).pack(codec), 3.013)
    rig.step()
    rig.close()
    assert [said.t_s for said in read_events(tmp_path) if said.name == "mode_changed"] == [3.013]
    assert max(row["t_s"] for row in read_truth(tmp_path)) == pytest.approx(3.05), "the ticks stay where they were"


@pytest.mark.sweep
def test_the_law_of_the_thesis_swings_at_20_m_and_not_at_45_m(tmp_path: Path) -> None:
    """Until shortly before the second turn. At 20 m it is not the departure that sets it off: it lies quiet until the
    first."""
    near, far = (
        sail("follow", tmp_path / test["gap"], 1, must_hold=False, time="114", **test)
        for test in (FIRST_TEST, SECOND_TEST)
    )
    assert near["following_share"] == 1.0, "no sensor is doubted for it"
    assert near["swing_after_bends_deg"] > 90.0 and far["swing_after_bends_deg"] < 30.0
    run = Chase(tmp_path / "20", 0.0)
    straight = (run.yaw - run.leader_yaw)[(run.t > 45.0) & (run.t < 75.0)]
    assert math.degrees(straight.max() - straight.min()) < 10.0


def test_words_that_do_not_exist_are_said(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"1\.2/1\.5"):
        sail("follow", tmp_path, 0, law="thesis", gains="1.2")
    with pytest.raises(ScenarioError, match="law=thesis"):
        sail("follow", tmp_path, 0, gains="1.2/1.5")
    with pytest.raises(ScenarioError, match="180@20"):
        sail("follow", tmp_path, 0, station="astern")
    with pytest.raises(ConfigError, match="vehicle"):
        sail("follow", tmp_path, 0, kind="gull")
    with pytest.raises(ConfigError, match="uturn"):
        sail("follow", tmp_path, 0, leader="loop")
    with pytest.raises(ScenarioError, match="moving"):
        sail("follow", tmp_path, 0, base="fixed")
    with pytest.raises(ScenarioError, match="difference"):
        sail("follow", tmp_path, 0, relative="best")


@pytest.mark.sweep
def test_receivers_with_errors_in_common_are_compared_with_each_other(tmp_path: Path) -> None:
    """The difference of like receivers is closer to the truth than the leader's position beside the boat's own
    estimate, over the seeds."""
    by, beside = (
        [sail("follow", tmp_path / way / str(seed), seed, common="0.9", relative=way) for seed in range(SEEDS)]
        for way in ("difference", "positions")
    )
    assert pooled_rms(by, "gap_rms_m") <= min(0.7, pooled_rms(beside, "gap_rms_m"))


# --- over 16 seeds -------------------------------------------------------------------------------------------------

_CONDITIONS: Mapping[str, Mapping[str, str]] = {
    "20 m": {},
    "45 m": {"gap": "45"},
    "4 m/s": {"leader": "thesis@4"},
    "14 m/s": {"leader": "thesis@14", "gap": "45"},
    "wrong by 30 %": {"plant_error": "0.3"},
    "wrong by 30 %, 45 m": {"plant_error": "0.3", "gap": "45"},
    "wrong by 30 %, 4 m/s": {"plant_error": "0.3", "leader": "thesis@4"},
    "wrong by 30 %, 14 m/s": {"plant_error": "0.3", "leader": "thesis@14", "gap": "45"},
    "worn": {"plant": "worn"},
    "slalom": {"leader": "slalom@8.2"},
    "u-turn": {"leader": "uturn@8.2"},
    "all of it": {"leader": "lively@8.2"},
    "stream": {"current": "0.5", "wind": "8"},
    "severe waves": {"waves": "0.8", "wind": "12"},
    "radio": {"kind": "radio", "latency": "0.1"},
    "phone": {"kind": "phone", "latency": "0.2"},
    "mavsdk": {"kind": "mavsdk", "latency": "0.2"},
    "vehicle": {"kind": "vehicle", "latency": "0.1"},
}


@pytest.mark.sweep
@pytest.mark.parametrize("changes", _CONDITIONS.values(), ids=_CONDITIONS.keys())
def test_astern_sweep(tmp_path: Path, changes: Mapping[str, str]) -> None:
    """Each run holds as far as its receivers know it; the truth is judged over all seeds. Two standalone receivers
    differ by 1.7 m (one sigma) each way, so that a follower without any error of its own is within 4 m of the true
    track 98 % of the time: its share is the yardstick."""
    runs = over_seeds(tmp_path, **changes)
    wake, ideal = (statistics.fmean(run[name] for run in runs) for name in ("in_wake_share", "receivers_in_wake_share"))
    assert wake >= 0.98 * ideal
    assert pooled_rms(runs, "gap_straight_rms_m") <= 2.0 + (0.5 if changes.get("kind") in ("phone", "mavsdk") else 0.0)
    assert pooled_rms(runs, "gap_bend_rms_m") <= 5.0


@pytest.mark.sweep
@pytest.mark.parametrize("gap", ["20", "45"])
def test_with_good_receivers_the_truth_holds_in_every_run(tmp_path: Path, gap: str) -> None:
    for metrics in over_seeds(tmp_path, gap=gap, gnss="sbas"):
        assert (
            metrics["in_wake_share"] >= 0.98
            and metrics["gap_straight_rms_m"] <= 2.0
            and metrics["gap_bend_rms_m"] <= 5.0
        )


@pytest.mark.sweep
def test_half_of_the_packets_lost(tmp_path: Path) -> None:
    whole, half = (over_seeds(tmp_path / loss, loss=loss) for loss in ("0", "0.5"))
    for name in (
        "off_rms_m",
        "gap_straight_rms_m",
        "gap_bend_rms_m",
        "known_off_rms_m",
        "known_gap_straight_rms_m",
        "nozzle_variation_1ps",
    ):
        assert pooled_rms(half, name) <= 1.5 * pooled_rms(whole, name), name


def test_beside_a_leader_that_has_stopped_steering_gathers_no_way(tmp_path: Path) -> None:
    sail("follow", tmp_path, 4, leader="stop@8.2", wind="8", current="0.5")


@pytest.mark.sweep
@pytest.mark.parametrize("leader", ["stop@2", "stop@4.5"])
def test_asked_too_near_a_jet_keeps_the_room_that_it_needs_when_its_leader_stops(tmp_path: Path, leader: str) -> None:
    """From 4.5 m/s it came to 11.2 m, where it was told to turn to either side by turns."""
    found = sail("follow", tmp_path, 741010, must_hold=False, leader=leader, gap="15", wind="6.6", time="110")
    assert found["nearest_m"] >= 12.0
    told = [row.text for row in read_events(tmp_path)]
    assert "Following system 100: 15 m astern, but 20 m is kept" in told


@pytest.mark.sweep
@pytest.mark.parametrize("leader", ["stop@8.2", "reverse@8.2"])
@pytest.mark.parametrize("weather", [{"wind": "4"}, {"wind": "8", "current": "0.5"}], ids=["breeze", "stream"])
def test_a_leader_that_stops_or_backs(tmp_path: Path, leader: str, weather: Mapping[str, str]) -> None:
    over_seeds(tmp_path, leader=leader, **weather)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(SEEDS))
@pytest.mark.parametrize("name", ["approach", "link_loss", "leader_gnss_loss", "station_change", "two_followers"])
def test_the_other_scenarios(tmp_path: Path, name: str, seed: int) -> None:
    sail(name, tmp_path, seed)


@pytest.mark.sweep
def test_what_the_thesis_found(tmp_path: Path) -> None:
    """On the plant with the thesis's linear actuator, without our supervision: after a turn the boat swings from side to
    side at 20 m with the gains of the first sea test, on most seeds, and goes steadily at 45 m with those of the
    second, on all, though it cuts corners out of the wake. Ours does neither where its file knows the actuator's
    rate."""
    near = over_seeds(tmp_path / "near", must_hold=False, **FIRST_TEST)
    far = over_seeds(tmp_path / "far", must_hold=False, **SECOND_TEST)
    swings = [run["swing_after_bends_deg"] for run in near]
    assert sum(swing > 90.0 for swing in swings) >= LEAST_THAT_SWING, swings
    assert max(run["swing_after_bends_deg"] for run in far) < 45.0
    vessel = slow_nozzle(tmp_path)
    for gap, theirs in (("20", near), ("45", far)):
        ours = [
            sail("follow", tmp_path / "ours" / gap / str(seed), seed, vessel=vessel, gap=gap) for seed in range(SEEDS)
        ]
        assert max(run["swing_after_bends_deg"] for run in ours) < 15.0
        assert pooled_rms(theirs, "known_off_rms_m") > 2.0 * pooled_rms(ours, "known_off_rms_m")
        assert pooled_rms(theirs, "throttle_variation_1ps") > 2.0 * pooled_rms(ours, "throttle_variation_1ps")


@pytest.mark.sweep
def test_a_boat_that_goes_sideways_too(tmp_path: Path) -> None:
    assert run(SCENARIOS["follow"], LockstepRig, tmp_path, seed=1, vessel="revolt").ok
