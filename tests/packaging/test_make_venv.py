"""The script that makes the virtual environment of `make`."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.packaging.installed import ROOT


def test_the_environment_of_another_checkout_keeps_its_packages(tmp_path: Path) -> None:
    theirs, ours = tmp_path / "theirs", tmp_path / "ours"
    theirs.mkdir()
    (theirs / "package.py").touch()
    ours.symlink_to(theirs)
    subprocess.run([sys.executable, ROOT / ".ci" / "make_venv.py", ours], check=True)
    assert (theirs / "package.py").exists()
    assert (ours / "bin" / "python").exists()
    assert not ours.is_symlink()
