"""A folder of another user, for tests that may run as root."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


def forbid(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let this process know that `folder` is there, and no more, as of lost+found at the top of a medium."""

    def guarded(call: Callable[..., Any], what_is_in_it: bool) -> Callable[..., Any]:
        def checked(path: Any = ".", *arguments: Any, **more: Any) -> Any:
            if not isinstance(path, int):
                asked = Path(os.fsdecode(path))
                if folder in asked.parents or (what_is_in_it and asked == folder):
                    raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(asked))
            return call(path, *arguments, **more)

        return checked

    for name, what_is_in_it in (("stat", False), ("lstat", False), ("listdir", True), ("scandir", True)):
        monkeypatch.setattr(os, name, guarded(getattr(os, name), what_is_in_it))
