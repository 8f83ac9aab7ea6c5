"""The site builds strictly, and loads nothing from elsewhere. `make docs` builds it too."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.pages import ROOT

pytest.importorskip("material", reason="pip install 'usv-companion[docs]'")


@pytest.mark.docs
def test_the_site_builds_strictly(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path / "site")]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "site" / "search" / "search_index.js").is_file()
    lists = (tmp_path / "site" / "use" / "sea-trials.html").read_text(encoding="utf-8")
    assert 'type="checkbox"' in lists and "[ ]" not in lists  # the lists of the day are printed
