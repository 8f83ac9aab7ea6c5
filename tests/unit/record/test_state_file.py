"""The state directory: what goes in comes out, whatever happened to the files in between."""

from __future__ import annotations

import errno
import json
import math
import os
import shutil
import struct
from pathlib import Path

import pytest

from companion.mission.plan import PlanItem, PlanKind, plan_id
from companion.params.store import Parameters
from companion.record.state_file import StateFile, StateFileBusy
from companion.record.writer import DirectWriter
from tests.unit.mission.item_bits import bits


def item(seq: int, **more: float) -> PlanItem:
    values: dict[str, float] = {"param1": 0.0, "param2": 0.0, "param3": 0.0, "param4": math.nan, "z": 50.0, **more}
    return PlanItem(seq=seq, command=16, frame=3, x=634_400_000 + seq, y=103_989_999 - seq, **values)  # type: ignore[arg-type]


def float32(value: float) -> float:
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def test_an_empty_directory_knows_nothing_and_complains_of_nothing(tmp_path: Path) -> None:
    state = StateFile(tmp_path / "not" / "there" / "yet")
    assert state.load_parameters() == ({}, [])
    assert state.load_plans() == (dict.fromkeys(PlanKind, ()), [])
    assert state.load_progress() == ({}, [])


def test_everything_comes_back_after_a_restart(tmp_path: Path) -> None:
    state = StateFile(tmp_path)
    mission = (
        item(0, param1=float32(0.1), z=math.nan),
        item(1, param1=struct.unpack("<f", b"\x01\x00\xc0\xff")[0], param2=-0.0, param3=math.inf),
        PlanItem(2, 177, 2, 0.0, 3.0, 0.0, 0.0, -(2**31), 2**31 - 1, float32(1e-42), 0, 1),
    )
    rally = (item(0),)
    state.save_parameters({"WP_SPEED": float32(0.7), "ALLOC_ITER": 4})
    state.save_plan(PlanKind.MISSION, mission)
    state.save_plan(PlanKind.RALLY, rally)
    state.save_progress({"seq": 2, "state": 3, "note": None})
    state.close()

    again = StateFile(tmp_path)
    assert again.load_parameters() == ({"WP_SPEED": float32(0.7), "ALLOC_ITER": 4}, [])
    plans, warnings = again.load_plans()
    assert warnings == []
    assert [bits(i) for i in plans[PlanKind.MISSION]] == [bits(i) for i in mission]
    assert [i.seq for i in plans[PlanKind.MISSION]] == [0, 1, 2]
    assert plan_id(plans[PlanKind.MISSION]) == plan_id(mission)  # the progress is of this plan
    assert [bits(i) for i in plans[PlanKind.RALLY]] == [bits(i) for i in rally]
    assert plans[PlanKind.FENCE] == ()
    assert again.load_progress() == ({"seq": 2, "state": 3, "note": None}, [])


def test_a_plan_file_is_json_of_the_strict_kind(tmp_path: Path) -> None:
    StateFile(tmp_path).save_plan(PlanKind.MISSION, (item(0),))

    def refuse(constant: str) -> float:
        raise AssertionError(constant)

    json.loads((tmp_path / "mission.json").read_text(), parse_constant=refuse)


def test_only_what_changed_is_kept_and_a_default_set_again_is_forgotten(tmp_path: Path) -> None:
    state, parameters = StateFile(tmp_path), Parameters()
    parameters.on_change(lambda name, value: state.save_parameters(parameters.changed()))
    parameters.set("WP_SPEED", 0.9)
    assert set(state.load_parameters()[0]) == {"WP_SPEED"}
    parameters.set("WP_SPEED", parameters.defaults["WP_SPEED"])
    assert state.load_parameters()[0] == {}


def test_parameters_of_another_version_are_kept_aside(tmp_path: Path) -> None:
    newer = StateFile(tmp_path, known_parameters={"WP_SPEED", "BRAND_NEW"})
    newer.save_parameters({"WP_SPEED": 0.5, "BRAND_NEW": 7})
    newer.close()
    older = StateFile(tmp_path, known_parameters={"WP_SPEED"})
    values, warnings = older.load_parameters()
    assert values == {"WP_SPEED": 0.5}
    assert len(warnings) == 1 and "BRAND_NEW" in warnings[0]
    older.save_parameters({"WP_SPEED": 0.6})
    older.close()
    assert StateFile(tmp_path, known_parameters={"WP_SPEED", "BRAND_NEW"}).load_parameters() == (
        {"WP_SPEED": 0.6, "BRAND_NEW": 7},
        [],
    )


def test_a_file_cut_off_at_any_length_is_set_aside_and_never_believed(tmp_path: Path) -> None:
    state = StateFile(tmp_path)
    state.save_plan(PlanKind.MISSION, (item(0), item(1)))
    whole = (tmp_path / "mission.json").read_bytes()
    for length in range(len(whole)):
        (tmp_path / "mission.json").write_bytes(whole[:length])
        plans, warnings = state.load_plans()
        assert plans[PlanKind.MISSION] == ()
        assert len(warnings) == 1 and f"mission.json.corrupt-{length + 1}" in warnings[0]
        assert not (tmp_path / "mission.json").exists()
        assert (tmp_path / f"mission.json.corrupt-{length + 1}").read_bytes() == whole[:length]
    (tmp_path / "mission.json").write_bytes(whole)
    assert len(state.load_plans()[0][PlanKind.MISSION]) == 2


@pytest.mark.parametrize("name", ["parameters.json", "mission.json", "fence.json", "rally.json", "progress.json"])
@pytest.mark.parametrize(
    "content",
    [
        b"\0" * 4096,
        b"\xff\xfe",
        b"[]",
        b"null",
        b"3",
        b'"text"',
        b"{}",
        b'{"format":2}',
        b'{"format":1}',
        b'{"format":1,"parameters":[],"columns":[],"items":[],"progress":[]}',
        b'{"format":1,"parameters":{"WP_SPEED":"fast"},"columns":3,"items":3,"progress":3}',
        b'{"format":1,"parameters":{"WP_SPEED":NaN},"columns":null,"items":null,"progress":null}',
        b'{"format":1,"parameters":{"WP_SPEED":true},"progress":"x"}',
        b'{"format":1,"parameters":{"WP_SPEED":1' + b"0" * 400 + b'},"progress":1}',
        b"[" * 100_000,
    ],
)
def test_nonsense_is_set_aside(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    state = StateFile(tmp_path)
    parameters, plans, progress = state.load_parameters(), state.load_plans(), state.load_progress()
    assert parameters[0] == {} and progress[0] == {} and not any(plans[0].values())
    assert len([*parameters[1], *plans[1], *progress[1]]) == 1
    assert (tmp_path / f"{name}.corrupt-1").read_bytes() == content


def test_the_parameter_that_is_no_number_is_named(tmp_path: Path) -> None:
    (tmp_path / "parameters.json").write_bytes(b'{"format":1,"parameters":{"ALLOC_ITER":3,"WP_SPEED":"fast"}}')
    _, (warning,) = StateFile(tmp_path).load_parameters()
    assert warning.endswith("corrupt (WP_SPEED is not a number); set aside as parameters.json.corrupt-1")


@pytest.mark.parametrize("column", range(11))
@pytest.mark.parametrize("value", ["x", "00000000", 1e300, 2**40, [], True])
def test_an_item_that_no_message_could_carry_is_refused(tmp_path: Path, column: int, value: object) -> None:
    state = StateFile(tmp_path)
    state.save_plan(PlanKind.MISSION, (item(0),))
    content = json.loads((tmp_path / "mission.json").read_text())
    carried = value == 2**40 and column in (2, 3, 4, 5, 8)
    content["items"][0][column] = value
    (tmp_path / "mission.json").write_text(json.dumps(content))
    plans, warnings = state.load_plans()
    assert len(plans[PlanKind.MISSION]) == carried
    assert len(warnings) == (not carried)


def test_a_second_companion_is_told_what_to_do(tmp_path: Path) -> None:
    first = StateFile(tmp_path)
    with pytest.raises(StateFileBusy, match="--state"):
        StateFile(tmp_path)
    first.close()
    StateFile(tmp_path)


def test_a_full_disk_is_a_warning_and_the_old_content_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    warnings: list[str] = []
    state = StateFile(tmp_path, warnings.append)
    state.save_plan(PlanKind.MISSION, (item(0),))

    def full(fd: int, data: object) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        state.save_plan(PlanKind.MISSION, (item(0), item(1)))
    assert len(warnings) == 1 and "No space left" in warnings[0]
    assert not list(tmp_path.glob("*.tmp"))
    assert len(state.load_plans()[0][PlanKind.MISSION]) == 1
    state.save_plan(PlanKind.MISSION, (item(0), item(1)))
    assert len(warnings) == 1 and len(state.load_plans()[0][PlanKind.MISSION]) == 2


def test_a_power_cut_before_the_rename_leaves_the_old_content(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    state = StateFile(tmp_path)
    state.save_plan(PlanKind.MISSION, (item(0),))

    def cut(self: Path, target: Path) -> Path:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", cut)
        with pytest.raises(KeyboardInterrupt):
            state.save_plan(PlanKind.MISSION, ())
    assert (tmp_path / "mission.json.tmp").exists()
    assert len(state.load_plans()[0][PlanKind.MISSION]) == 1


def test_the_content_is_on_the_medium_before_it_takes_the_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    state = StateFile(tmp_path)
    steps: list[str] = []
    fsync, replace = os.fsync, Path.replace

    def noted_fsync(fd: int) -> None:
        steps.append("sync directory" if os.path.isdir(f"/proc/self/fd/{fd}") else "sync file")  # noqa: PTH112
        fsync(fd)

    def noted_replace(self: Path, target: Path) -> Path:
        steps.append("rename")
        return replace(self, target)

    monkeypatch.setattr(os, "fsync", noted_fsync)
    monkeypatch.setattr(Path, "replace", noted_replace)
    state.save_progress({"seq": 1})
    assert steps == ["sync file", "rename", "sync directory"]


def test_a_directory_that_cannot_be_made_is_a_warning(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    warnings: list[str] = []
    state = StateFile(tmp_path / "file" / "state", warnings.append)
    assert len(warnings) == 1
    assert state.load_parameters() == ({}, [])
    assert state.load_plans()[1] == []
    state.save_parameters({"WP_SPEED": 1.0})
    state.save_progress({"what": object()})
    assert len(warnings) == 3


def test_ten_thousand_items_come_back(tmp_path: Path) -> None:
    state = StateFile(tmp_path)
    items = tuple(item(seq) for seq in range(10_000))
    state.save_plan(PlanKind.MISSION, items)
    assert [bits(i) for i in state.load_plans()[0][PlanKind.MISSION]] == [bits(i) for i in items]


def test_a_directory_that_is_removed_under_way_loses_nothing(tmp_path: Path) -> None:
    """What an earlier run has stored is in the next one's memory alone, then."""
    folder, warnings = tmp_path / "state", []  # type: ignore[var-annotated]
    before = StateFile(folder)
    before.save_parameters({"WP_SPEED": 0.5})
    before.save_plan(PlanKind.FENCE, (item(0),))
    before.close()
    state = StateFile(folder, warnings.append)
    state.load_parameters(), state.load_plans()
    state.write_with(DirectWriter(folder))
    shutil.rmtree(folder)
    assert state.save_progress({"seq": 1}).durable
    state.writer.retry()
    state.close()
    again = StateFile(folder)
    assert again.load_parameters()[0] == {"WP_SPEED": 0.5} and len(again.load_plans()[0][PlanKind.FENCE]) == 1
    assert again.load_progress()[0] == {"seq": 1}
    assert len(warnings) == 1 and "was removed" in warnings[0]


def test_what_could_not_be_loaded_is_lost_until_it_is_stored_anew(tmp_path: Path) -> None:
    for name in ("parameters.json", "fence.json", "wear.json"):
        (tmp_path / name).write_bytes(b'{"format":1,"it')
    state = StateFile(tmp_path)
    assert state.lost == ()
    state.load_parameters()
    state.load_plans()
    state.load_wear()
    assert state.lost == ("Parameters lost at start: the defaults count", "Fence lost at start: upload it again")
    state.save_plan(PlanKind.FENCE, ())
    assert state.lost == ("Parameters lost at start: the defaults count",)
    state.plan_refused(PlanKind.RALLY)
    state.save_parameters({})
    assert state.lost == ("Rally points lost at start: upload them again",)
    assert all(len(text) <= 50 for text in state.lost)
    state.close()
