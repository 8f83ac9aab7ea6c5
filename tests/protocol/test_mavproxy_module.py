"""The project's own MAVProxy module in the real MAVProxy, headless, flown against the running process."""

from __future__ import annotations

import itertools
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from companion.core.geodesy import LocalFrame
from companion.io.mavlink.wire import messages as mavlink
from companion.params.table import TABLE
from tests.protocol.desk import Sender
from tests.protocol.mavproxy import MavProxy
from tests.protocol.process import Companion, free_port

pytestmark = pytest.mark.process

MODULE = "gcs_plugins.mavproxy.mavproxy_usv"
FRAME = LocalFrame(63.4389, 10.3990)
TAKEN = "Got COMMAND_ACK: {}: ACCEPTED"


@contextmanager
def phone(port: int) -> Iterator[None]:
    """FOLLOW_TARGET of a leader that lies 40 m ahead, 25 times a second, as another system."""
    lat_deg, lon_deg = FRAME.to_geodetic(40.0, 0.0)
    over, sender = threading.Event(), Sender(77)

    def send() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            for n in itertools.count():
                if over.wait(0.04):
                    break
                at = (40 * n, 3, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)
                rest = ([0.0] * 3, [0.0] * 3, [1.0, 0.0, 0.0, 0.0], [0.0] * 3, [2.0, 0.0, 2.0], 0)
                out.sendto(sender.packed(mavlink.MAVLink_follow_target_message(*at, *rest)), ("127.0.0.1", port))

    thread = threading.Thread(target=send)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def in_mode(station: MavProxy, mode: str) -> None:
    """By the module's own status: MAVProxy itself tells of a new mode up to 2 s later."""
    station.ask("usv status", f"usv: {mode}, ", again_s=0.3)


def test_holding_nudging_docking_following_and_tuning(tmp_path: Path) -> None:
    port = free_port(socket.SOCK_STREAM)
    phone_port = free_port()
    links = (f"tcpin:127.0.0.1:{port}", f"udpin:127.0.0.1:{phone_port}")
    with (
        Companion(tmp_path, speed=5.0, links=links),
        MavProxy(f"tcp:127.0.0.1:{port}", tmp_path / "mavproxy", (MODULE,)) as station,
    ):
        station.expect(f"Loaded module {MODULE}")
        station.expect(f"Received {len(TABLE)} parameters")
        station.say("usv help")
        station.expect("usv station BEARING_DEG DISTANCE_M: follow position")
        station.expect("usv nudge-ahead: .*in Hold, armed")
        station.say("usv status")
        station.expect(r"usv: Manual, disarmed, 63\.43\d+ 10\.39\d+, heading \d+ deg")
        station.expect("usv: bow thruster: (up|down)")

        station.say("usv nudge 1 0")
        station.expect("Got COMMAND_ACK: USER_1: TEMPORARILY_REJECTED")
        station.say("usv hold")
        station.expect(TAKEN.format("DO_SET_MODE"))
        station.say("usv arm")
        station.expect("Arm thrusters: propellers may turn from now on. usv arm yes sends it")
        station.ask("usv arm yes", TAKEN.format("COMPONENT_ARM_DISARM"), again_s=2.0)
        station.ask("usv status", r"usv: DP: 0\.\d+ m off the setpoint, heading [+-]\d")
        station.say("usv nudge 1 -0.5 5")
        station.expect(TAKEN.format("USER_1"))
        station.say("usv turn 90")
        station.expect(TAKEN.format("USER_1"))
        station.say("usv goto {:.7f} {:.7f} 45 0.5".format(*FRAME.to_geodetic(5.0, 5.0)))
        station.expect(TAKEN.format("DO_REPOSITION"))
        station.say("usv lower yes")
        station.expect(TAKEN.format("USER_2"))
        station.say("usv station 135 25")
        station.expect(TAKEN.format("USER_3"))
        station.say("param set FOLL_LOSS_T 10")
        station.ask("param show FOLL_LOSS_T", r"FOLL_LOSS_T\s+10")
        station.say("usv follow yes")
        station.expect("Follow waits for the leader: no leader heard")
        with phone(phone_port):
            station.ask("usv follow yes", TAKEN.format("DO_FOLLOW"))
            station.ask(
                "usv status", r"usv: Follow, armed[^\n]*\n+usv: follow: \d+ m to go, towards \d+ deg", again_s=0.3
            )
        station.say("usv dock yes")
        in_mode(station, "Dock")
        station.say("usv stop")
        station.expect(TAKEN.format("COMPONENT_ARM_DISARM"))
        station.ask("usv status", "usv: Dock, disarmed")

        station.say("usv tune path-speed up")
        station.expect(r"usv: PATH_BW_SURGE 0\.440 rad/s")
        station.say("usv tune path-speed 0.5")
        station.expect(r"usv: PATH_BW_SURGE 0\.220 rad/s")
        station.say("usv tune")
        station.expect(r"usv: DP_BW_SWAY 0\.\d+ rad/s")

        for mistake, said in MISTAKES.items():
            station.say(f"usv {mistake}")
            station.expect(said)
        station.say("module unload usv")
        station.expect("Unloaded module usv")
        station.say("usv status")
        station.expect("Unknown command 'usv status'")


MISTAKES = {
    "nudge": r"usage: usv nudge AHEAD_M STARBOARD_M \[TURN_DEG\]",
    "nudge nan 0": "usage: usv nudge",
    "goto 95 10": "usv goto: give latitude and longitude in degrees",
    "station 180": "usage: usv station",
    "tune sideways up": "usage: usv tune .*loops are dp, ",
    "tune dp 100": "usv tune: give a factor from 0.1 to 10",
    "hold now": "usv hold takes no arguments",
    "sing": "usv sing: no such command",
}


def test_a_mission_on_a_link_that_speaks_ardupilot(tmp_path: Path) -> None:
    """Modes by Rover's numbers there."""
    port = free_port(socket.SOCK_STREAM)
    lines = ["QGC WPL 110", "0\t1\t0\t16\t0\t0\t0\t0\t63.4389\t10.399\t0\t1"]
    corners = ((8.0, 0.0), (8.0, 8.0), (0.0, 8.0))
    for n, corner in enumerate(corners, start=1):
        lat_deg, lon_deg = FRAME.to_geodetic(*corner)
        lines.append(f"{n}\t0\t3\t16\t0\t0\t0\t0\t{lat_deg:.7f}\t{lon_deg:.7f}\t0\t1")
    plan = tmp_path / "plan.txt"
    plan.write_text("\n".join(lines) + "\n", encoding="utf-8")
    links = (f"tcpin:127.0.0.1:{port}?dialect=ardupilot",)
    with (
        Companion(tmp_path, speed=10.0, links=links),
        MavProxy(f"tcp:127.0.0.1:{port}", tmp_path / "mavproxy", (MODULE,)) as station,
    ):
        station.expect("online system 1")
        station.say(f"wp load {plan}")
        station.expect("Got MISSION_ACK: TYPE_MISSION: ACCEPTED")
        station.say("usv hold")
        in_mode(station, "Hold")
        station.ask("usv arm yes", TAKEN.format("COMPONENT_ARM_DISARM"), again_s=2.0)
        station.say("usv start yes")
        in_mode(station, "Mission")
        station.ask("usv status", r"usv: path: \d+\.\d\d m to (port|starboard) of it, \d+ m to go, item [1-3]")
        station.say("usv pause")
        in_mode(station, "Hold")
        station.say("usv continue yes")
        in_mode(station, "Mission")
        station.say("usv return yes")
        in_mode(station, "RTL")
        station.say("usv watch 1")
        station.expect("usv: RTL, armed")
        station.expect("usv: RTL, armed")
        station.say("usv watch off")
        station.say("usv stop")
        station.expect(TAKEN.format("COMPONENT_ARM_DISARM"))
