"""Reboot and erasing of logs, asked for by MAVSDK of the running process."""

from __future__ import annotations

from pathlib import Path

import pytest
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.action import Action
from mavsdk.plugins.log_files import LogFiles
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import Telemetry

from tests.protocol.process import Companion
from tests.waiting import CAP_S, wait_until

pytestmark = pytest.mark.process


def test_it_restarts_in_its_place_and_forgets_old_logs_when_told(tmp_path: Path) -> None:
    with (
        Companion(tmp_path, speed=3.0) as companion,
        Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk,
    ):
        sdk.add_any_connection(f"udpin://127.0.0.1:{companion.udp_port}")
        system = sdk.first_autopilot(CAP_S)
        assert system is not None and companion.process is not None and companion.process.stdout is not None
        action, telemetry = Action(system), Telemetry(system)
        Param(system).set_param_float("PATH_BW_SURGE", 0.5)
        wait_until(lambda: telemetry.health().is_armable, "ready to arm")
        action.arm()
        with pytest.raises(Exception, match="DENIED"):
            action.reboot()
        action.disarm()
        wait_until(lambda: not telemetry.armed(), "disarmed")

        first, pid = companion.log_folder, companion.process.pid
        action.reboot()
        companion.hello = companion.read_hello()
        assert companion.process.poll() is None and companion.process.pid == pid
        assert companion.log_folder != first and first.exists()
        again = wait_until(lambda: _parameter(system), "the parameter, of the process that began anew")
        assert again == 0.5

        LogFiles(system).erase_all_log_files()
        wait_until(lambda: not first.exists(), "erased")
        assert (companion.log_folder / "manifest.json").exists()


def _parameter(system: object) -> float | None:
    try:
        return float(Param(system).get_param_float("PATH_BW_SURGE"))
    except Exception:  # noqa: BLE001  MAVSDK's own, while nobody answers
        return None
