"""The leader module's command."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.main import main

_CONFIG = """
name = "lead"
system_id = 42
links = ["udpout:127.0.0.1:1"]

[[sensor]]
name = "gnss"
driver = "nmea0183"
port = "udpin:127.0.0.1:0"
"""


def test_old_logs_of_a_leader_module_go_when_they_are_too_large(tmp_path: Path) -> None:
    """Its logs grew until the medium was full: only `companion run` knew --log-limit."""
    old, config = tmp_path / "logs" / "lead-20250101-000000", tmp_path / "lead.toml"
    old.mkdir(parents=True)
    (old / "manifest.json").write_text("{}")
    (old / "log.mcap").write_bytes(bytes(1_100_000))
    config.write_text(_CONFIG)
    run = ["leader", str(config), "--log", str(old.parent), "--duration", "0.1"]
    assert main(run) == 0 and old.exists()
    assert main([*run, "--log-limit", "1"]) == 0 and not old.exists()


def test_a_limit_of_nothing_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["leader", "viknes", "--log", str(tmp_path), "--log-limit", "0"]) == 2
    assert "must be at least 1 MB" in capsys.readouterr().err
