"""Files of leader modules."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.config.vessel import ConfigError
from companion.leader_module.app import load_leader
from companion.leader_module.config import bundled_leaders, find_leader, parse_leader

GOOD = """
name = "lead"
system_id = 42
links = ["udpout:127.0.0.1:14600"]
[[sensor]]
name = "gnss"
driver = "nmea0183"
port = "serial:/dev/usv-gnss:115200"
"""


@pytest.mark.parametrize("name", bundled_leaders())
def test_the_examples_are_without_errors(name: str) -> None:
    config = load_leader(name)
    assert config.name == name and config.rate_hz == 20.0 and config.thrifty == "auto"


def test_what_is_left_out_is_usual(tmp_path: Path) -> None:
    path = tmp_path / "lead.toml"
    path.write_text(GOOD, encoding="utf-8")
    config = load_leader(str(path))
    assert (config.follower, config.joystick, config.local_links, config.home.lat_deg) == (1, None, (), 0.0)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("follower = 42", "lead.toml:4: system_id: 42 is the follower's"),
        ("rate_hz = 100.0", "lead.toml:2: rate_hz: should be less than or equal to 50"),
        ('thrifty = "often"', "thrifty"),
        ("colour = 1", "lead.toml:2: colour: unknown key"),
        (
            'local_links = ["serial:/dev/usv-gnss:4800"]',
            "lead.toml:2: local_links[1]: 'serial:/dev/usv-gnss:4800': sensor 'gnss' has /dev/usv-gnss too",
        ),
        ('local_links = ["can:can0"]', "lead.toml:2: local_links[1]: 'can:can0': MAVLink does not go over CAN"),
        ('local_links = ["udpin:0.0.0.0:14600?telemetry=lead"]', "telemetry should be one of all, leader"),
        ("thrifty =", "lead.toml:2: not valid TOML: "),
        ('local_links = ["telnet:1"]', "local_links[1]: 'telnet:1': should begin with one of"),
    ],
)
def test_errors_name_their_place(tmp_path: Path, change: str, said: str) -> None:
    path = tmp_path / "lead.toml"
    path.write_text(f"\n{change}{GOOD}", encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_leader(str(path))
    assert any(said in problem for problem in caught.value.problems), caught.value.problems


def test_every_error_at_once(tmp_path: Path) -> None:
    path = tmp_path / "lead.toml"
    twice = (
        GOOD.replace("nmea0183", "nmea2000")
        + GOOD[GOOD.index("[[sensor]]") :]
        + "[parameters]\nFS_POS_T = -1\nNO_SUCH = 3\n"
    )
    path.write_text(twice, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_leader(str(path))
    text = "\n".join(caught.value.problems)
    assert "used twice" in text and "no driver 'nmea2000'" in text and "FS_POS_T" in text and "NO_SUCH" in text


def test_a_file_that_is_not_there() -> None:
    with pytest.raises(ConfigError, match="no leader module 'nowhere'; bundled: viknes"):
        find_leader("nowhere")
    with pytest.raises(ConfigError, match="not valid TOML"):
        parse_leader("name =", "place")
