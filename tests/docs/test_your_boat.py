"""The tutorial of one's own boat, run block by block in a folder of its own."""

from __future__ import annotations

import os
import re
import stat
import subprocess
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import pytest

from tests.copies import run_to_end
from tests.docs.pages import DOCS, ON_THE_BOAT, ROOT, blocks_of
from tests.island import island_if_any

PAGE = DOCS / "start" / "your-boat.md"
LINKED = ("run", "thruster-test")  # the simulation's default links have fixed ports: on a network of their own
PLAIN = re.compile(r"companion [\w ./=@+-]+")


def plain(text: str) -> list[list[str]] | None:
    """The arguments of each line, where all are `companion` with plain words and none opens the default links."""
    lines = text.splitlines()
    words = [line.split()[1:] for line in lines if PLAIN.fullmatch(line)]
    return words if len(words) == len(lines) and not any(row[0] in LINKED for row in words) else None


@pytest.mark.process
@pytest.mark.skipif(not PAGE.is_file(), reason="the page is not written yet")
def test_every_block_of_the_tutorial_runs_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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
    for name, value in (places | told).items():
        monkeypatch.setenv(name, value)
    monkeypatch.chdir(work)
    ran = shells = 0
    with island_if_any() as within:
        for block in blocks_of(PAGE):
            if block.language == "sh" and block.title != ON_THE_BOAT:
                commands = plain(block.text)
                shells += commands is None
                for run in [partial(shell, within, block.text)] if commands is None else copies(commands):
                    done = run()
                    assert done.returncode == 0, f"{block.place}:\n{block.text}\n{done.stdout}\n{done.stderr}"
                ran += 1
    assert shells >= 1 and ran > shells


def copies(commands: list[list[str]]) -> list[Callable[[], subprocess.CompletedProcess[str]]]:
    return [partial(run_to_end, *arguments) for arguments in commands]


def shell(within: Sequence[str], text: str) -> subprocess.CompletedProcess[str]:
    """The block as a person's shell runs it."""
    command = [*within, "sh", "-e", "-c", text]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
