"""A medium that fails while a fault says so."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from companion.config.vessel import find, load
from companion.record.disk import REAL_DISK
from sitl.faults import Faults
from sitl.medium import FaultyMedium


@pytest.mark.parametrize(("fault", "number"), [("disk_full", errno.ENOSPC), ("disk_read_only", errno.EROFS)])
def test_it_fails_during_the_fault_and_works_before_and_after(tmp_path: Path, fault: str, number: int) -> None:
    faults = Faults([f"{fault}@10+5"], load(find("revolt")))
    medium = FaultyMedium(REAL_DISK, faults)
    descriptor = medium.begin(tmp_path / "log")
    for t_s, fails in ((9.0, False), (12.0, True), (16.0, False)):
        faults.update(t_s)
        calls = (
            lambda: medium.append(descriptor, b"x"),
            lambda: medium.sync(descriptor),
            lambda: medium.replace(tmp_path, "state", b"y", 0o644, None),
        )
        for call in calls:
            if fails:
                with pytest.raises(OSError) as raised:
                    call()
                assert raised.value.errno == number
            else:
                call()
    os.close(descriptor)
    assert (tmp_path / "log").read_bytes() == b"xx" and (tmp_path / "state").read_bytes() == b"y"
