"""The tutorial of one's own boat, run block by block in a folder of its own."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.pages import DOCS, ON_THE_BOAT, ROOT, blocks_of
from tests.island import island_if_any

PAGE = DOCS / "start" / "your-boat.md"


@pytest.mark.process
@pytest.mark.skipif(not PAGE.is_file(), reason="the page is not written yet")
def test_every_block_of_the_tutorial_runs_in_order(tmp_path: Path) -> None:
    work, programs = tmp_path / "work", tmp_path / "bin"
    work.mkdir()
    programs.mkdir()
    for name in ("companion", "mission_files"):
        (work / name).symlink_to(ROOT / name)
    companion = programs / "companion"
    companion.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m companion "$@"\n')
    companion.chmod(companion.stat().st_mode | stat.S_IXUSR)
    places = {"PATH": f"{programs}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT), "HOME": str(tmp_path)}
    told = {name: str(tmp_path / "home") for name in ("XDG_DATA_HOME", "XDG_STATE_HOME", "XDG_CONFIG_HOME")}
    ran = 0
    with island_if_any() as within:  # the simulation's default links have fixed ports
        for block in blocks_of(PAGE):
            if block.language == "sh" and block.title != ON_THE_BOAT:
                done = subprocess.run(
                    [*within, "sh", "-e", "-c", block.text],
                    cwd=work,
                    env={**os.environ, **places, **told},
                    capture_output=True,
                    text=True,
                    check=False,
                    timeout=600,
                )
                assert done.returncode == 0, f"{block.place}:\n{block.text}\n{done.stdout}\n{done.stderr}"
                ran += 1
    assert ran >= 1
