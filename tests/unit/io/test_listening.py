"""Listening on a port whose device is unplugged meanwhile."""

from __future__ import annotations

import os
import pty
import tty
from pathlib import Path

import pytest

from companion.io.listening import PortListener


@pytest.mark.parametrize("sent", [b"", b"\x55" * 700], ids=["silent", "nonsense"])
def test_a_device_that_is_unplugged_ends_its_own_port_alone(sent: bytes) -> None:
    device, port = pty.openpty()
    tty.setraw(port)
    path = Path(os.ttyname(port))
    os.close(port)
    listener = PortListener(path, 2.0)
    listener.update(0.0)
    os.write(device, sent)
    listener.update(0.1)
    os.close(device)
    for k in range(40):
        listener.update(0.2 + 0.1 * k)
    assert listener.done and bool(listener.recogniser.bytes) is bool(sent)
    assert listener.fault == ("it was unplugged meanwhile" if sent else None)
