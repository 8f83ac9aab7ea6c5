"""`usvctl` against the running process, as scripts call it: what it prints, its exit codes, the boat's reasons."""

from __future__ import annotations

import os
import socket
import struct
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from companion.core.geodesy import LocalFrame
from companion.mission import files
from companion.mission.plan import PlanItem
from companion.mission.plan_file import PlanFile
from companion.params.table import TABLE
from gcs_plugins.usvctl.cli import main
from tests.protocol.process import Companion, free_port
from tests.waiting import run_to_end

pytestmark = pytest.mark.process

MISSIONS = Path(__file__).parents[2] / "mission_files"
FRAME = LocalFrame(63.4389, 10.3990)
OLD_RUN = "revolt-20260101-120000"
OLD_LOG = b"ULog\x01\x12\x35\x01" + bytes(range(256)) * 200

Said = tuple[int, str, str]
Usvctl = Callable[..., Said]


@pytest.fixture(scope="module")
def companion(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Companion]:
    """Links of both personas that a script may meet, and a run of long ago in the log folder."""
    folder = tmp_path_factory.mktemp("usvctl")
    old = folder / "logs" / OLD_RUN
    old.mkdir(parents=True)
    (old / "manifest.json").write_bytes(b"{}")
    os.utime(old / "manifest.json", (1_700_000_000, 1_700_000_000))
    (old / "ticks.ulg").write_bytes(OLD_LOG)
    port = free_port()
    rover = f"tcpin:127.0.0.1:{free_port(socket.SOCK_STREAM)}?dialect=ardupilot"
    running = Companion(folder, speed=10.0, links=(f"udpout:127.0.0.1:{port}", rover))
    with running:
        running.sail(5.0)  # it knows where it is then
        yield running


@pytest.fixture
def usvctl(companion: Companion, capsys: pytest.CaptureFixture[str]) -> Usvctl:
    px4, rover = (hello.strip() for hello in companion.hello[1].removeprefix("links:").split(","))

    def call(*words: str, ardupilot: bool = False) -> Said:
        link = (
            f"tcpout://{rover.split('?')[0].removeprefix('tcpin:')}"
            if ardupilot
            else f"udpin://{px4.removeprefix('udpout:')}"
        )
        code = main(["--link", link, *words])
        out, err = capsys.readouterr()
        return code, out, err

    return call


def place(north_m: float, east_m: float) -> tuple[str, str]:
    lat_deg, lon_deg = FRAME.to_geodetic(north_m, east_m)
    return f"{lat_deg:.7f}", f"{lon_deg:.7f}"


def as_stored(item: PlanItem) -> PlanItem:
    """Numbers as the wire has them, in 32 bits."""
    p1, p2, p3, p4, z = struct.unpack(
        "<5f", struct.pack("<5f", item.param1, item.param2, item.param3, item.param4, item.z)
    )
    return replace(item, param1=p1, param2=p2, param3=p3, param4=p4, z=z, current=0)


def lists(plan: PlanFile) -> list[str]:
    """Comparable, NaN included."""
    return [repr([as_stored(item) for item in items]) for items in (plan.mission, plan.fence, plan.rally)]


def of_file(path: Path) -> PlanFile:
    return files.read(path.name, path.read_text(encoding="utf-8"))


def test_steering_and_the_boats_reasons(usvctl: Usvctl) -> None:
    assert usvctl("nudge", "1", "0") == (1, "", "refused: Nudge refused: Manual is not Hold\n")
    assert usvctl("checks") == (0, "nothing prevents arming\n", "")
    assert usvctl("hold")[0] == 0
    assert usvctl("arm")[0] == 0
    assert usvctl("goto", *place(3.0, 2.0), "--heading", "30", "--speed", "0.5", "--wait", "--within", "60") == (
        0,
        "",
        "",
    )
    assert usvctl("nudge", "-1", "0.5", "5")[0] == 0
    assert usvctl("nudge", "9", "0") == (1, "", "refused: Nudge refused: 9.0 m, DP_NUDGE_MAX is 3 m\n")
    code, _, said = usvctl("follow", "--station", "180@2")
    assert code == 1 and "FOLL_MIN_DIST" in said
    assert usvctl("params", "set", "FOLL_WAIT_T", "0")[0] == 0
    assert usvctl("follow", "--station", "180@20") == (1, "", "refused: Follow refused: no leader heard\n")
    code, _, said = usvctl("goto", *place(40.0, 0.0), "--wait", "--within", "0.5")
    assert code == 1 and said == "refused: not there after 0.5 s\n"
    assert usvctl("dock")[0] == 0
    assert usvctl("mode", "Manual", ardupilot=True)[0] == 0
    code, shown, _ = usvctl("watch", "--seconds", "1.2")
    assert code == 0 and shown.startswith("Manual, armed, 63.43")
    assert usvctl("stop")[0] == 0


def test_status_tells_the_state_and_whether_the_boat_is_ready(usvctl: Usvctl) -> None:
    code, said, error = usvctl("status")
    lines = said.splitlines()
    assert (code, error, lines[-1]) == (0, "", "Ready")
    assert "Failsafes: none" in lines and any(line.startswith("Battery: ") for line in lines)
    assert any("ok" in line for line in lines if "udpout:" in line)
    assert usvctl("status", ardupilot=True)[0] == 0


@pytest.mark.parametrize("ardupilot", [False, True])
def test_plans_come_back_as_they_went(usvctl: Usvctl, tmp_path: Path, ardupilot: bool) -> None:
    """A plan with jumps, fence and no rally points, over one with rally points; on a link whose item 0 is home as
    well."""
    plan, back = MISSIONS / "laps.plan", tmp_path / "back.plan"
    assert usvctl("upload", str(MISSIONS / "trondheim_square.plan"), ardupilot=ardupilot)[0] == 0
    code, out, _ = usvctl("upload", str(plan), ardupilot=ardupilot)
    assert code == 0 and out == "uploaded: 12 items, fence 4, rally points 0\n"
    assert usvctl("download", str(back), ardupilot=ardupilot)[0] == 0
    assert lists(of_file(back)) == lists(of_file(plan))
    assert usvctl("download", str(tmp_path / "other.plan"), ardupilot=not ardupilot)[0] == 0
    assert lists(of_file(tmp_path / "other.plan")) == lists(of_file(plan))


def route(path: Path, *points: tuple[float, float]) -> str:
    """A .plan of waypoints, metres north and east of home."""
    corners = [FRAME.to_geodetic(*point) for point in points]
    items = [
        PlanItem(n, 16, 3, 0, 0, 0, 0, round(lat * 1e7), round(lon * 1e7), 0) for n, (lat, lon) in enumerate(corners)
    ]
    path.write_text(files.write(path.name, PlanFile(tuple(items))), encoding="utf-8")
    return str(path)


def test_a_mission_is_sailed_to_its_end(usvctl: Usvctl, tmp_path: Path) -> None:
    assert usvctl("upload", route(tmp_path / "near.plan", (4.0, 0.0), (8.0, 2.0)))[0] == 0
    code, _, said = usvctl("start", "--arm", "--wait", "--within", "90")
    assert code == 0 and "100%" in said
    assert usvctl("disarm")[0] == 0
    assert usvctl("upload", route(tmp_path / "far.plan", (900_000.0, 0.0)))[0] == 0
    code, _, said = usvctl("start")
    assert code == 1 and "km away" in said
    unknown = PlanFile((PlanItem(0, 84, 3, 0, 0, 0, 0, 634389000, 103990000, 0),))
    (tmp_path / "unknown.plan").write_text(files.write("unknown.plan", unknown), encoding="utf-8")
    code, _, said = usvctl("upload", str(tmp_path / "unknown.plan"))
    assert code == 1 and "refused: mission item 1: command 84 is not supported" in said
    code, _, said = usvctl("upload", str(MISSIONS / "README.md"))
    assert code == 2 and "unknown kind of plan file" in said


def test_parameters(usvctl: Usvctl, tmp_path: Path) -> None:
    saved = tmp_path / "usv.params"
    assert usvctl("params", "get", "PATH_BW_SURGE", "NAV_DLL_ACT") == (0, "PATH_BW_SURGE 0.4\nNAV_DLL_ACT 1\n", "")
    assert usvctl("params", "save", str(saved)) == (0, f"{saved}: {len(TABLE)} parameters\n", "")
    assert usvctl("params", "set", "PATH_BW_SURGE", "0.5") == (0, "1 of 1 changed\n", "")
    assert usvctl("params", "set", "NAV_DLL_ACT", "2") == (0, "1 of 1 changed\n", "")
    assert usvctl("params", "set", "NAV_DLL_ACT", "3", ardupilot=True) == (0, "1 of 1 changed\n", "")
    assert usvctl("params", "get", "NAV_DLL_ACT")[1] == "NAV_DLL_ACT 3\n"
    assert usvctl("params", "load", str(saved)) == (0, f"2 of {len(TABLE)} changed\n", "")
    assert usvctl("params", "get", "PATH_BW_SURGE")[1] == "PATH_BW_SURGE 0.4\n"
    code, _, said = usvctl("params", "set", "PATH_BW_SURGE", "99")
    assert code == 1 and "it takes 0.05 to 3 rad/s" in said
    assert usvctl("params", "set", "NAV_DLL_ACT", "1.5")[0] == 2
    assert usvctl("params", "get", "NOPE") == (2, "", "usvctl: no such parameter: NOPE\n")
    saved.write_text("PATH_BW_SURGE high\n", encoding="utf-8")
    assert usvctl("params", "load", str(saved))[0] == 2


def test_logs_and_files(usvctl: Usvctl, tmp_path: Path) -> None:
    code, listed, _ = usvctl("logs", "list")
    first = listed.splitlines()[0].split()
    assert code == 0 and int(first[2]) == len(OLD_LOG)
    code, got, _ = usvctl("logs", "get", first[0], "--dir", str(tmp_path / "new"))
    assert code == 0 and got.endswith(".ulg\n") and Path(got.strip()).read_bytes() == OLD_LOG
    assert usvctl("logs", "get", "77")[0] == 2
    assert f"{OLD_RUN}/" in usvctl("files", "list", "/logs")[1].splitlines()
    code, got, _ = usvctl("files", "get", f"/logs/{OLD_RUN}/ticks.ulg", "--dir", str(tmp_path))
    assert code == 0 and Path(got.strip()).read_bytes() == OLD_LOG
    assert usvctl("files", "get", "/../secret", "--dir", str(tmp_path))[0] == 1


def test_it_runs_as_a_program_and_says_when_nobody_is_there() -> None:
    command = [
        sys.executable,
        "-m",
        "gcs_plugins.usvctl",
        "--timeout",
        "0.3",
        "--link",
        f"udpin://127.0.0.1:{free_port()}",
        "hold",
    ]
    done = run_to_end(command)
    assert done.returncode == 2 and done.stdout == "" and done.stderr.startswith("usvctl: no boat heard on")
