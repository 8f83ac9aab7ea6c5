"""The log with the new gains is looked for beside that of the trial."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from companion.cli import keeping


def test_a_folder_that_is_not_ours_to_read_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """lost+found beside the logs ended `companion trial report`."""
    for name in ("a_trial", "lost+found"):
        (tmp_path / name).mkdir()
    looked = Path.is_file

    def is_file(path: Path) -> bool:
        if path.parent.name == "lost+found":
            raise PermissionError(13, "Permission denied", str(path))
        return looked(path)

    monkeypatch.setattr(Path, "is_file", is_file)
    monkeypatch.setattr(keeping, "measured", lambda log, how: None)
    found: Any = SimpleNamespace(log=SimpleNamespace(folder=tmp_path / "a_trial"), designs=())
    assert keeping.keepings(found, predict=False) == ()
