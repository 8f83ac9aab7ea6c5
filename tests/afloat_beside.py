"""A whole vessel whose writers and worker run in threads of their own, as on a boat, while its time is the test's."""

from __future__ import annotations

from pathlib import Path

from companion.record.disk import REAL_DISK, Disk
from tests.afloat import BoatAfloat


class BoatBeside(BoatAfloat):
    """Its state and logs are below `folder`."""

    def __init__(
        self,
        folder: Path,
        disk: Disk = REAL_DISK,
        logs: bool = True,
        link: str = "memory:desk",
        vessel: str = "revolt",
    ) -> None:
        log_folder = folder / "logs" / "run" if logs else None
        super().__init__(folder / "state", log_folder, beside=True, disk=disk, link=link, vessel=vessel)
