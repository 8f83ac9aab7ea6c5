"""Which links obey anybody in the network."""

from __future__ import annotations

import pytest

from companion.config import vessel as config_module
from companion.io.mavlink.wire.exposure import exposed


@pytest.mark.parametrize(
    ("url", "open_to_all"),
    [
        ("tcpin:0.0.0.0:5760", True),
        ("udpin:0.0.0.0:14550?signing=accept", True),
        ("tcpin:192.168.1.20:5760?dialect=ardupilot", True),
        ("tcpin:[::]:5760", True),
        ("tcpin:boat.local:5760", True),
        ("tcpin:0.0.0.0:5760?signing=require", False),
        ("tcpin:127.0.0.1:5760", False),
        ("udpin:localhost:14550", False),
        ("tcpin:[::1]:5760", False),
        ("udpout:192.168.1.10:14550", False),
        ("serial:/dev/usv-radio:57600", False),
        ("memory:a", False),
        ("tcpin:0.0.0.0:5760?signing=perhaps", False),
    ],
)
def test_links_that_listen_beyond_this_computer_without_signatures(url: str, open_to_all: bool) -> None:
    assert exposed(url) is open_to_all


@pytest.mark.parametrize("vessel", config_module.bundled())
def test_no_bundled_boat_has_one(vessel: str) -> None:
    assert not any(map(exposed, config_module.load(config_module.find(vessel)).links))
