"""A short run in lockstep, and its log through the same code again."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.analysis.compare import LogDifference
from companion.analysis.log_reader import LogError, open_log, read_table
from companion.analysis.replay import Spread, replay
from companion.analysis.rerun import rerun
from companion.app import Surroundings, build
from companion.cli.main import main
from companion.cli.rig import LockstepRig
from companion.clock import SimulatedClock
from companion.config import vessel as config_module
from companion.core.readings import Corrections, Depth
from companion.io.mavlink.wire.links import MemoryLink
from companion.mission.plan import PlanItem, PlanKind
from companion.record.protobuf import parts_of
from companion.record.readings import read_ticks
from companion.record.recorder import LogFolder
from companion.record.state_file import StateFile
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.rig import Conditions
from sitl.traffic import ScriptedVessel
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions
from tests import mcap_edit
from tests.unit.io.mavlink.hub.test_rtcm import qgroundcontrol as cut
from tests.unit.io.test_rtcm import frame

_HOLD = 0x03040000
_FORCES = 0x00020000
_MISSION = 0x04040000


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Hold in wind, a go-to, a parameter changed under way, a nudge, a thruster that dies, a mission, a lost ground
    station, sticks."""
    folder = tmp_path_factory.mktemp("log")
    rig = LockstepRig(
        Conditions(
            "revolt",
            seed=3,
            wind="2",
            faults=("thruster_bow_dead@20+5",),
            parameters={"THR_WATCH": 0.0, "COM_DL_LOSS_T": 5.0},
        ),
        folder,
    )
    station = GroundStation(rig)
    station.ready()
    station.set_mode(_HOLD)
    station.arm()
    home = rig.config.home
    station.command(mavlink.MAV_CMD_DO_REPOSITION, -1.0, 1.0, 0.0, 0.5, home.lat_deg + 2e-5, home.lon_deg, math.nan)
    station.sail(5.0)
    station.set_parameter("DP_DAMPING", 0.7)
    station.sail(5.0)
    station.command(mavlink.MAV_CMD_USER_1, 1.0, 0.5, 0.3, 5.0)
    station.sail(5.0)
    station.upload([Item(16, home.lat_deg + 1e-4, home.lon_deg), Item(16, home.lat_deg + 1e-4, home.lon_deg + 1e-4)])
    station.set_mode(_MISSION)
    station.sail(8.0)
    for _ in range(80):  # silent for longer than COM_DL_LOSS_T
        rig.step()
    station.send(mavlink.MAVLink_manual_control_message(1, 500, 0, 0, 100, 0))
    station.set_mode(_FORCES)
    for _ in range(20):
        station.send(mavlink.MAVLink_manual_control_message(1, 500, 0, 0, 100, 0))
        station.step()
    rig.close()
    return folder


@pytest.fixture(scope="module")
def again(recorded: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[LogDifference, Path]:
    """The run done again, and its folder."""
    folder = tmp_path_factory.mktemp("again") / "log"
    return rerun(open_log(recorded), folder), folder


def copied(recorded: Path, folder: Path) -> Path:
    return Path(shutil.copytree(recorded, folder / "log"))


def test_the_same_code_gives_the_same_estimates_to_the_last_bit(recorded: Path, tmp_path: Path) -> None:
    result = replay(open_log(recorded), tmp_path / "replay.csv")
    assert result.ticks > 200 and result.warnings == []
    assert result.largest_in_log() == 0.0


def test_the_same_code_does_the_whole_run_again_to_the_last_bit(
    recorded: Path, again: tuple[LogDifference, Path]
) -> None:
    result, out = again
    assert result.same and result.warnings == [] and result.ticks > 350
    assert (out / "ticks.csv").read_bytes() == (recorded / "ticks.csv").read_bytes()
    assert (out / "events.csv").read_bytes() == (recorded / "events.csv").read_bytes()
    events = (recorded / "events.csv").read_text(encoding="utf-8")
    for name in ("go_to", "nudge", "thruster_bow", "station_lost", "mode_changed"):
        assert f",{name}," in events, "the run has what it is to be replayed for"


def test_traffic_is_part_of_the_run(tmp_path: Path) -> None:
    """A vessel that the boat's own receiver hears, and one that a peer tells of."""
    folder = tmp_path / "log"
    rig = LockstepRig(Conditions("revolt", seed=3, ais=True, parameters={"CA_ACTION": 3.0}), folder)
    station = GroundStation(rig)
    rig.world.traffic.vessels.append(
        ScriptedVessel(230_000_001, "NORA", ((0.0, 130.0, 0.0), (300.0, -170.0, 0.0)), report_s=2.0)
    )
    station.ready()
    home = rig.config.home
    station.upload([Item(16, home.lat_deg + 2e-3, home.lon_deg)])
    station.set_mode(_MISSION)
    station.arm()
    station.sail(5.0)
    sized = mavlink.AIS_FLAGS_VALID_COG | mavlink.AIS_FLAGS_VALID_VELOCITY
    place = (round((home.lat_deg + 1e-3) * 1e7), round(home.lon_deg * 1e7))
    station.send(mavlink.MAVLink_ais_vessel_message(5, *place, 0, 65535, 20, 0, 0, 0, 0, 0, 0, 0, b"", b"", 1, sized))
    station.sail(25.0)
    rig.close()
    assert any("course to starboard" in text for text in station.texts)
    assert rerun(open_log(folder), tmp_path / "again").same


def test_corrections_and_instruments_are_part_of_the_run(tmp_path: Path) -> None:
    """Corrections of a ground station that come, stop and are back, a sounder, and a receiver that is told of them."""
    text = config_module.find("revolt").read_text(encoding="utf-8").replace('"nmea0183"', '"nmea0183"\nrtcm = true', 1)
    text = text.replace(
        "[dock]", '[[sensor]]\nname = "sounder"\ndriver = "nmea0183"\nport = "udpin:0.0.0.0:10110"\nrate_hz = 5\n[dock]'
    )
    (tmp_path / "boat.toml").write_text(text, encoding="utf-8")
    rig = LockstepRig(Conditions(str(tmp_path / "boat.toml"), seed=3), tmp_path / "log")
    station, told = GroundStation(rig), [frame(200, seed) for seed in range(20)]
    for second in range(26):
        if second < 5 or second > 20:
            for flags, data in cut(told[second % 20], second):
                station.send(mavlink.MAVLink_gps_rtcm_data_message(flags, len(data), list(data.ljust(180, b"\0"))))
        station.sail(1.0)
    port = rig.world.open("gnss", "")
    assert b"".join(data for _, data in port.device.receive(1e6)) == b"".join(
        told[second % 20] for second in (*range(5), *range(21, 26))
    )
    rig.close()
    events = (tmp_path / "log" / "events.csv").read_text(encoding="utf-8")
    assert "corrections_lost" in events and "corrections_back" in events
    result = rerun(open_log(tmp_path / "log"), tmp_path / "again")
    assert result.same
    assert {type(r) for t in read_ticks(tmp_path / "again" / "log.mcap", []) for r in t.readings} >= {
        Depth,
        Corrections,
    }


def test_a_silent_receiver_is_bridged_by_the_thrust_of_the_log(tmp_path: Path) -> None:
    """Dead reckoning weighs in what the hull's model makes of the thrust."""
    rig = LockstepRig(Conditions("revolt", seed=3, wind="2", faults=("gnss_lost@14+4",)), tmp_path / "log")
    station = GroundStation(rig)
    station.ready()
    station.set_mode(_HOLD)
    station.arm()
    station.sail(20.0)
    rig.close()
    log = open_log(tmp_path / "log")
    assert replay(log, tmp_path / "replay.csv").largest_in_log() == 0.0
    assert rerun(log, tmp_path / "again").same


def test_every_vessel_is_done_again_to_the_last_bit(tmp_path: Path) -> None:
    """Each with its own sensors: a compass, a wind sensor, cameras."""
    for vessel in ("aboat", "cybership2"):
        rig = LockstepRig(Conditions(vessel, seed=3, wind="2", current="0.1"), tmp_path / vessel)
        station = GroundStation(rig)
        station.ready()
        station.set_mode(_HOLD)
        station.arm()
        station.sail(5.0)
        rig.close()
        log = open_log(tmp_path / vessel)
        assert replay(log, tmp_path / f"{vessel}.csv").largest_in_log() == 0.0
        assert rerun(log, tmp_path / f"{vessel}-again").same


def test_a_replay_can_itself_be_replayed(again: tuple[LogDifference, Path], tmp_path: Path) -> None:
    first, folder = again
    assert first.same and rerun(open_log(folder), tmp_path / "second").same


def without(recorded: Path, folder: Path, unwanted: Callable[[str, bytes], bool]) -> Path:
    """A copy of the log without some of its messages."""
    log = copied(recorded, folder)
    assert mcap_edit.without(log / "log.mcap", unwanted) > 0
    return log


def bears(number: int) -> Callable[[str, bytes], bool]:
    """Whether a message is a MAVLink 2 packet with this message that came in."""

    def asked(topic: str, data: bytes) -> bool:
        if topic != "/packet":
            return False
        packet = next(value for field, _, value in parts_of(data) if field == 4)
        return packet[0] == 0xFD and int.from_bytes(packet[7:10], "little") == number

    return asked


def test_the_first_difference_is_where_an_input_was_taken_out(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = without(recorded, tmp_path, bears(mavlink.MAVLINK_MSG_ID_PARAM_SET))
    assert main(["replay", str(log), "--all"]) == 1
    shown = capsys.readouterr().out
    assert "first: at " in shown and "demanded force" in shown and "another mode" not in shown
    ticks = read_table(log / "ticks.csv", ("t_s",), [])["t_s"]
    assert ticks[0] + 6.0 < float(shown.partition("first: at ")[2].split()[0]) < 12.0
    assert (log / "replay" / "ticks.csv").exists()


def test_another_decision_is_told(recorded: Path, tmp_path: Path) -> None:
    log = without(recorded, tmp_path, bears(mavlink.MAVLINK_MSG_ID_SET_MODE))
    result = rerun(open_log(log), tmp_path / "again")
    assert result.words["mode"] > 100 and not result.within(1e3) and "Mode Hold" in result.first_event


def test_another_hull_is_told_by_the_wrench_alone(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = copied(recorded, tmp_path)
    manifest: dict[str, Any] = json.loads((log / "manifest.json").read_text(encoding="utf-8"))
    manifest["configuration"]["hull"]["m11_kg"] *= 1.2
    (log / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    result = rerun(open_log(log), tmp_path / "again")
    largest = {one.name: one for one in result.largest}
    assert largest["position"].size == 0.0 and largest["demanded force"].size > 0.1
    assert f"{largest['demanded force'].t_s:.1f} s" in result.report()
    assert main(["replay", str(log), "--all", "--tolerance", "1000"]) == 0


def test_plans_and_parameters_of_before_the_run_are_part_of_it(tmp_path: Path) -> None:
    """A vessel with a memory, that sails the mission of yesterday."""
    config = config_module.load(config_module.find("revolt"))
    state = StateFile(tmp_path / "state")
    home = config.home
    points = [(home.lat_deg + 1e-4, home.lon_deg), (home.lat_deg + 1e-4, home.lon_deg + 2e-4)]
    items = [
        PlanItem(i, 16, 6, 0.0, 0.0, 0.0, math.nan, round(a * 1e7), round(b * 1e7), 0.0, 1, 0)
        for i, (a, b) in enumerate(points)
    ]
    state.save_plan(PlanKind.MISSION, items)
    state.save_parameters({"WP_SPEED": 0.5})
    clock, link, world = (
        SimulatedClock(EPOCH_UNIX_NS),
        MemoryLink("memory:?dialect=ardupilot"),
        World(config, WorldConditions(seed=1)),
    )
    folder = tmp_path / "log"
    vessel = build(config, Surroundings(clock, world, world, [link], state, folder, False, None, {"DP_WATCH_R": 1.5}))
    codec = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    for tick in range(200):
        clock.wait(tick * vessel.period_s, ())
        if tick % 10 == 0:
            link.to_vessel(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(codec))
        if tick == 60:
            link.to_vessel(mavlink.MAVLink_set_mode_message(1, 1, 10).pack(codec))  # Auto, as ArduPilot's boats have it
            link.to_vessel(mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1.0, 0, 0, 0, 0, 0, 0).pack(codec))
        vessel.tick(clock.now_s())
        vessel.load = 0.001 * tick  # as the runner measures it, for the next row
        if tick % 7 == 3:
            vessel.serve(clock.now_s())  # between two ticks
    vessel.close()
    state.save_plan(PlanKind.MISSION, ())
    state.close()
    ticks = (folder / "ticks.csv").read_text(encoding="utf-8")
    assert ",Mission,1," in ticks, "it sailed"
    assert rerun(open_log(folder), tmp_path / "again").same
    (folder / "state" / "mission.json").unlink()
    assert rerun(open_log(folder), tmp_path / "other").words["mode"] > 50


def test_it_is_near_the_truth_and_the_csv_says_so(recorded: Path, tmp_path: Path) -> None:
    out = tmp_path / "replay.csv"
    result = replay(open_log(recorded), out)
    assert result.against_truth is not None and result.against_truth.position.count > 150
    assert 0.0 < result.against_truth.position.rms < 0.05 and result.against_truth.heading.largest < 0.03
    warnings: list[str] = []
    table = read_table(out, ("t_s", "north_m", "recorded_north_m"), warnings)
    ticks = read_table(recorded / "ticks.csv", ("t_s", "north_m"), warnings)
    assert warnings == [] and len(table["t_s"]) == result.ticks == len(ticks["t_s"])
    assert table["north_m"] == pytest.approx(ticks["north_m"], abs=1e-4)


def test_other_code_is_told_apart_and_the_tolerance_decides(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = copied(recorded, tmp_path)
    assert main(["replay", str(log)]) == 0
    manifest: dict[str, Any] = json.loads((log / "manifest.json").read_text(encoding="utf-8"))
    manifest["configuration"]["sensors"][0]["x_m"] += 0.02
    (log / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    capsys.readouterr()
    assert main(["replay", str(log), "--out", str(tmp_path / "other.csv")]) == 1
    assert "against the truth" in capsys.readouterr().out
    assert (tmp_path / "other.csv").exists()
    assert main(["replay", str(log), "--tolerance", "0.5"]) == 0


def test_a_power_cut_leaves_a_run_that_can_be_done_again(recorded: Path, tmp_path: Path) -> None:
    log = copied(recorded, tmp_path)
    for name in ("log.mcap", "ticks.csv", "events.csv"):
        data = (log / name).read_bytes()
        (log / name).write_bytes(data[: len(data) // 2 | 1])
    result = rerun(open_log(log), tmp_path / "again")
    assert result.ticks > 100 and result.differing == 0 and result.warnings


@pytest.mark.parametrize("name", ["log.mcap", "ticks.csv", "events.csv"])
def test_a_run_whose_files_a_power_cut_left_of_other_lengths_is_the_same_as_far_as_it_goes(
    recorded: Path, tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    log = copied(recorded, tmp_path)
    data = (log / name).read_bytes()
    at = data.rindex(b"\n", 0, 3 * len(data) // 4) - 1  # in the last cell of a row
    (log / name).write_bytes(data[:at] + (b"\xc2" if name == "events.csv" else b""))
    assert main(["replay", str(log), "--all", "--out", str(tmp_path / "again")]) == 0
    said = capsys.readouterr().out
    assert ", 0 of them different" in said if name == "events.csv" else "the same to the last digit, events too" in said
    assert ("ticks at the end are not done again: the log has lost their inputs" in said) is (name == "log.mcap")


@pytest.mark.parametrize(("column", "differing"), [("load", 1), ("time_unix_ns", 1)])
def test_a_row_that_lacks_a_value_does_not_end_the_run(
    recorded: Path, tmp_path: Path, column: str, differing: int
) -> None:
    """What came after it was not done again, for its inputs were lost, it said."""
    log = with_empty_cell(recorded, tmp_path, column)
    result = rerun(open_log(log), tmp_path / "again")
    assert result.warnings == ["ticks.csv:51: no time_unix_ns or load; both go on from the row before"]
    assert result.lost_ticks == 0 and result.differing == differing and result.within(1e-9)


@pytest.mark.parametrize("line", [2, 51])
def test_a_row_without_a_time_does_not_end_the_run(recorded: Path, tmp_path: Path, line: int) -> None:
    log = with_empty_cell(recorded, tmp_path, "t_s", lines=(line,))
    result = rerun(open_log(log), tmp_path / "again")
    assert result.warnings == [f"ticks.csv:{line}: row omitted: no time"]
    assert result.lost_ticks == result.missing_ticks == 0
    rows = len((log / "ticks.csv").read_text().splitlines()) - 1
    assert result.ticks == rows - 1


@pytest.mark.parametrize("column", ["load", "time_unix_ns"])
def test_first_rows_that_lack_a_value_go_back_from_the_first_whole_one(
    recorded: Path, tmp_path: Path, column: str
) -> None:
    """They were left out without a word, with the inputs of their ticks."""
    log = with_empty_cell(recorded, tmp_path, column, lines=(2, 3))
    result = rerun(open_log(log), tmp_path / "again")
    said = "no time_unix_ns or load; both go back from row 4"
    assert result.warnings == [f"ticks.csv:2: {said}", f"ticks.csv:3: {said}"]
    assert result.lost_ticks == result.missing_ticks == 0 and result.differing <= 2 and result.within(1e-9)
    assert result.ticks == len((log / "ticks.csv").read_text().splitlines()) - 1


def with_empty_cell(recorded: Path, folder: Path, column: str, lines: tuple[int, ...] = (51,)) -> Path:
    """A copy of the log without the value of `column` in those lines of ticks.csv."""
    log = copied(recorded, folder)
    rows = (log / "ticks.csv").read_text().split("\n")
    for line in lines:
        cells = rows[line - 1].split(",")
        cells[rows[0].split(",").index(column)] = ""
        rows[line - 1] = ",".join(cells)
    (log / "ticks.csv").write_text("\n".join(rows))
    return log


def test_a_log_of_the_replay_that_stopped_is_not_the_same(
    recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, again = copied(recorded, tmp_path), tmp_path / "again"

    def half(self: LogFolder) -> None:
        close(self)
        data = (again / "ticks.csv").read_bytes()
        (again / "ticks.csv").write_bytes(data[: len(data) // 2])

    close = LogFolder.close
    monkeypatch.setattr(LogFolder, "close", half)
    result = rerun(open_log(log), again)
    assert result.missing_ticks > 50 and result.lost_ticks == 0 and not result.within(1.0)


def test_a_truth_of_which_a_power_cut_left_nothing_is_told(recorded: Path, tmp_path: Path) -> None:
    log = copied(recorded, tmp_path)
    (log / "truth.csv").write_bytes(b"")
    result = replay(open_log(log), tmp_path / "replay.csv")
    assert result.against_truth is None and any("truth.csv" in warning for warning in result.warnings)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.90001])
def test_a_log_of_a_power_cut_is_replayed_as_far_as_it_goes(recorded: Path, tmp_path: Path, share: float) -> None:
    log = copied(recorded, tmp_path)
    for name in ("log.mcap", "truth.csv"):
        data = (log / name).read_bytes()
        (log / name).write_bytes(data[: int(share * len(data)) | 1])
    result = replay(open_log(log), tmp_path / "replay.csv")
    assert result.ticks > 10 and result.largest_in_log() <= 1e-9
    assert any("log.mcap" in warning for warning in result.warnings)


def test_what_cannot_be_replayed_is_said(recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = copied(recorded, tmp_path)
    (log / "log.mcap").write_bytes((log / "log.mcap").read_bytes()[:4000])
    with pytest.raises(LogError, match="no whole tick"):
        replay(open_log(log), tmp_path / "replay.csv")
    (log / "log.mcap").unlink()
    (log / "truth.csv").unlink()
    assert main(["replay", str(log)]) == 2
    assert "recorded without its readings" in capsys.readouterr().err


def test_a_log_without_its_inputs_is_no_run_to_do_again(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = copied(recorded, tmp_path)
    assert main(["replay", str(log), "--all", "--out", str(log)]) == 2
    assert "the log itself" in capsys.readouterr().err
    manifest: dict[str, Any] = json.loads((log / "manifest.json").read_text(encoding="utf-8"))
    del manifest["patience"]
    (log / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    assert main(["replay", str(log), "--all"]) == 2
    assert "its estimates can be replayed without --all" in capsys.readouterr().err


def test_a_difference_that_is_no_number_counts_as_infinite() -> None:
    spread = Spread("m")
    spread.add(0.1)
    spread.add(math.nan)
    assert spread.largest == math.inf
