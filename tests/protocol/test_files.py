"""Files over MAVLink FTP, fetched from the running process by clients that we did not write."""

from __future__ import annotations

import json
import lzma
import os
import random
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.ftp import Ftp, FtpResult
from mavsdk.plugins.log_files import LogFiles, LogFilesResult
from pyulog import ULog

from companion.params.table import TABLE
from tests.protocol.lossy import LossyNetwork
from tests.protocol.mavproxy import MavProxy
from tests.protocol.process import Companion, free_port
from tests.waiting import run_to_end

pytestmark = pytest.mark.process

OLD_RUN = "revolt-20260101-120000"


@pytest.fixture(scope="module")
def companion(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Companion]:
    folder = tmp_path_factory.mktemp("files")
    old = folder / "logs" / OLD_RUN
    old.mkdir(parents=True)
    (old / "manifest.json").write_bytes(b"{}")
    os.utime(old / "manifest.json", (1_700_000_000, 1_700_000_000))
    (old / "telemetry.tlog").write_bytes(random.Random(1).randbytes(123_456))
    with Companion(folder, speed=3.0) as running:
        yield running


def pymavlink_ftp(companion: Companion, *arguments: str, loss: int = 0) -> subprocess.CompletedProcess[str]:
    """pymavlink's own client, as a person runs it."""
    command = [
        sys.executable,
        "-W",
        "ignore",
        "-m",
        "pymavlink.mavftp",
        f"--device=tcp:127.0.0.1:{companion.tcp_port}",
        "--loglevel=INFO",
    ]
    command += [
        f"--pkt_loss_tx={loss}",
        f"--pkt_loss_rx={loss}",
        "--read_retry_time=0.3",
        "--retry_time=0.3",
        *arguments,
    ]
    return run_to_end(command)


def test_pymavlink_fetches_a_log_and_the_metadata_byte_for_byte_over_loss(companion: Companion, tmp_path: Path) -> None:
    log = tmp_path / "old.tlog"
    done = pymavlink_ftp(
        companion, "--burst_read_size=239", "get", f"@MAV_LOG/{OLD_RUN}/telemetry.tlog", str(log), loss=10
    )
    assert log.is_file(), done.stderr[-2000:]
    assert log.read_bytes() == (companion.folder / "logs" / OLD_RUN / "telemetry.tlog").read_bytes()
    described = tmp_path / "parameters.json.xz"
    pymavlink_ftp(companion, "get", "/parameters.json.xz", str(described), loss=10)
    names = [row["name"] for row in json.loads(lzma.decompress(described.read_bytes()))["parameters"]]
    assert names == sorted(spec.name for spec in TABLE)


def test_pymavlink_lists_and_reads_the_packed_parameters(companion: Companion, tmp_path: Path) -> None:
    listed = pymavlink_ftp(companion, "list", "/logs")
    assert OLD_RUN in listed.stdout + listed.stderr
    values = tmp_path / "values.param"
    done = pymavlink_ftp(companion, "getparams", str(values))
    assert values.is_file(), done.stderr[-2000:]
    found = dict(line.replace(",", " ").split()[:2] for line in values.read_text().splitlines() if line.strip())
    assert set(found) == {spec.name for spec in TABLE}


def test_mavsdk_lists_and_downloads_by_burst_and_by_blocks(companion: Companion, tmp_path: Path) -> None:
    with Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk:
        sdk.add_any_connection(f"udpin://127.0.0.1:{companion.udp_port}")
        system = sdk.first_autopilot(10.0)
        assert system is not None
        ftp = Ftp(system)
        listing = ftp.list_directory("/logs")
        assert OLD_RUN in [entry.name for entry in listing.entries]
        expected = (companion.folder / "logs" / OLD_RUN / "telemetry.tlog").read_bytes()
        for burst in (True, False):
            target = tmp_path / f"burst_{burst}"
            target.mkdir()
            path = f"/logs/{OLD_RUN}/telemetry.tlog" if burst else "/general.json"
            assert _download(ftp, path, target, burst) is FtpResult.SUCCESS
            got = (target / Path(path).name).read_bytes()
            assert got == expected if burst else b"metadataTypes" in got
        assert _download(ftp, "/logs/../state/parameters.toml", tmp_path, True) is not FtpResult.SUCCESS


def _download(ftp: Ftp, path: str, target: Path, burst: bool) -> FtpResult:
    over = threading.Event()
    last: list[FtpResult] = []

    def progress(result: FtpResult, data: object, user_data: object) -> None:
        last.append(result)
        if result is not FtpResult.NEXT:
            over.set()

    ftp.download_async(path, str(target), burst, progress)
    assert over.wait(60.0), f"{path} does not come"
    return last[-1]


def test_mavsdk_downloads_a_log_that_pyulog_opens(companion: Companion, tmp_path: Path) -> None:
    with Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk:
        sdk.add_any_connection(f"udpin://127.0.0.1:{companion.udp_port}")
        system = sdk.first_autopilot(10.0)
        assert system is not None
        logs = LogFiles(system)
        old, present = logs.get_entries()
        assert old.size_bytes == 123_456
        for entry, name in ((old, "old"), (present, "present.ulg")):
            over = threading.Event()

            def progress(result: LogFilesResult, data: object, user_data: object, over: threading.Event = over) -> None:
                if result is not LogFilesResult.NEXT:
                    over.set()

            logs.download_log_file_async(entry, str(tmp_path / name), progress)
            assert over.wait(60.0)
    assert (tmp_path / "old").read_bytes() == (companion.folder / "logs" / OLD_RUN / "telemetry.tlog").read_bytes()
    opened = ULog(str(tmp_path / "present.ulg"))
    assert opened.msg_info_dict["sys_name"] == "USV companion" and len(opened.initial_parameters) == len(TABLE)
    whole = (companion.log_folder / "ticks.ulg").read_bytes()
    assert whole.startswith((tmp_path / "present.ulg").read_bytes())


def test_mavproxy_lists_and_downloads_a_log(companion: Companion, tmp_path: Path) -> None:
    with MavProxy(f"tcp:127.0.0.1:{companion.tcp_port}", tmp_path / "mavproxy") as station:
        station.expect("Detected vehicle 1:1")
        station.ask("log list", r"Log 0\s+numLogs 2 lastLog 1 size 123456", again_s=3.0)
        station.say(f"log download 0 {tmp_path / 'old.bin'}")
        station.expect(r"Finished downloading")
    assert (tmp_path / "old.bin").read_bytes() == (companion.folder / "logs" / OLD_RUN / "telemetry.tlog").read_bytes()


def test_mavsdk_and_mavproxy_fetch_over_a_bad_network(tmp_path: Path) -> None:
    """One datagram in ten vanishes, each way; what arrives is whole."""
    old = tmp_path / "logs" / OLD_RUN
    old.mkdir(parents=True)
    (old / "telemetry.tlog").write_bytes(random.Random(2).randbytes(60_000))
    expected = (old / "telemetry.tlog").read_bytes()
    mavsdk_port, mavproxy_port = free_port(), free_port()
    with (
        LossyNetwork(mavsdk_port, 0.1, 1) as first,
        LossyNetwork(mavproxy_port, 0.1, 2) as second,
        Companion(tmp_path, speed=3.0, links=(f"udpout:127.0.0.1:{first.port}", f"udpout:127.0.0.1:{second.port}")),
    ):
        with Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk:
            sdk.add_any_connection(f"udpin://127.0.0.1:{mavsdk_port}")
            system = sdk.first_autopilot(20.0)
            assert system is not None
            ftp = Ftp(system)
            for path in ("/parameters.json.xz", f"/logs/{OLD_RUN}/telemetry.tlog"):
                assert any(_download(ftp, path, tmp_path, True) is FtpResult.SUCCESS for _ in range(3)), path
        with MavProxy(f"udpin:127.0.0.1:{mavproxy_port}", tmp_path / "mavproxy") as station:
            station.expect("Detected vehicle 1:1")
            station.say(f"ftp get /logs/{OLD_RUN}/telemetry.tlog {tmp_path / 'proxy.tlog'}")
            station.expect(r"Wrote 60000 bytes|Wrote 60000/60000")
            station.say(f"ftp get /parameters.json.xz {tmp_path / 'proxy.xz'}")
            size = (tmp_path / "parameters.json.xz").stat().st_size  # the line of the first file may come last
            station.expect(rf"Wrote {size} bytes|Wrote {size}/{size}")
    assert first.lost > 10 and second.lost > 10
    assert (tmp_path / "telemetry.tlog").read_bytes() == (tmp_path / "proxy.tlog").read_bytes() == expected
    described = (tmp_path / "parameters.json.xz").read_bytes()
    assert described == (tmp_path / "proxy.xz").read_bytes() and b"DP_BW_SURGE" in lzma.decompress(described)
