"""Every command on the pages could be typed: its program, its words and its options exist."""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
import io
import re
import shlex
import tomllib
from pathlib import Path

import pytest

from companion.cli.main import argument_parser
from docs.generate.command_line import commands
from gcs_plugins.usvctl.cli import argument_parser as usvctl_parser
from tests.docs.pages import ROOT, Block, blocks, blocks_of, label, spans, written

# Programs of others, whose words are not checked.
_OTHERS = frozenset(
    {
        "apt",
        "cd",
        "cp",
        "curl",
        "dask",
        "docker",
        "echo",
        "git",
        "journalctl",
        "mavproxy.py",
        "mkdir",
        "pipx",
        "scp",
        "sed",
    }
    | {"source", "ssh", "systemctl", "tail", "unzip", "usermod", "uv", "ip", "nmcli", "less", "ls", "rm", "export"}
)
_BEGINS = frozenset({"sudo", "time", "nohup", "env"})
_ASSIGNMENT = re.compile(r"[A-Z_]+=.*")
_EXTRA = re.compile(r"\[([\w,-]+)\]")
COMPANION, USVCTL = argument_parser(), usvctl_parser()


def _lines(block: Block) -> list[str]:
    """The command lines of a block, without comments, long ones joined."""
    text = block.text.replace("\\\n", " ")
    return [line for raw in text.splitlines() if (line := raw.strip()) and not line.startswith("#")]


def _simple(line: str) -> list[list[str]]:
    """The commands of a line, each as its words, without what stands before a program."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars=True)
    lexer.whitespace_split = True
    found: list[list[str]] = [[]]
    for word in lexer:
        if set(word) <= set("();<>|&"):
            found.append([])
        else:
            found[-1].append(word)
    stripped = []
    for words in found:
        while words and (words[0] in _BEGINS or _ASSIGNMENT.fullmatch(words[0])):
            words = words[1:]
        stripped.append(words)
    return [words for words in stripped if words]


def _parsed(parser: argparse.ArgumentParser, words: list[str]) -> str | None:
    """What the program's own parser has against these words."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            parser.parse_args(words)
    except SystemExit as end:
        return said.getvalue().strip().splitlines()[-1] if end.code else None
    return None


def _make(words: list[str]) -> str | None:
    targets = re.findall(r"^([a-z][\w-]*):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    asked = [word for word in words if "=" not in word and not word.startswith("-")]
    missing = [word for word in asked if word not in targets]
    return f"no target {', '.join(missing)} in the Makefile" if missing else None


def _pip(words: list[str]) -> str | None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = {extra for word in words for found in _EXTRA.findall(word) for extra in found.split(",")}
    missing = extras - project["optional-dependencies"].keys()
    return f"no extra {', '.join(sorted(missing))} in pyproject.toml" if missing else None


def _python(words: list[str]) -> str | None:
    if words[:1] != ["-m"]:
        return None
    if words[1] == "pip":
        return _pip(words[2:])
    if words[1] in ("companion", "venv"):
        return _parsed(COMPANION, words[2:]) if words[1] == "companion" else None
    return None if importlib.util.find_spec(words[1]) else f"no module {words[1]}"


def _fault(words: list[str]) -> str | None:
    """Why this command could not be typed; None where it could."""
    program = Path(words[0]).name
    if program == "companion":
        return _parsed(COMPANION, words[1:])
    if program == "usvctl":
        return _parsed(USVCTL, words[1:])
    if program == "make":
        return _make(words[1:])
    if program in ("pip", "pip3"):
        return _pip(words[1:])
    if program.startswith("python"):
        return _python(words[1:])
    return None if program in _OTHERS else f"unknown program {program}: if it is right, add it to this test"


@pytest.mark.parametrize("block", list(blocks("sh")), ids=lambda block: block.place)
def test_every_line_of_a_shell_block_could_be_typed(block: Block) -> None:
    faults = [f"{line}: {fault}" for line in _lines(block) for words in _simple(line) if (fault := _fault(words))]
    assert not faults, f"{block.place}: " + "; ".join(faults)


@pytest.mark.parametrize("path", written(), ids=label)
def test_no_shell_block_hides_under_another_name(path: Path) -> None:
    """`sh` alone is checked."""
    others = [block.place for block in blocks_of(path) if block.language in ("bash", "shell", "console", "")]
    assert not others, f"blocks without a language, or with one that no test checks: {', '.join(others)}"


_OPTION = re.compile(r"--[a-z][a-z-]+")


def _known(parser: argparse.ArgumentParser, name: str) -> dict[str, set[str]]:
    """Options of every command of a program, by its words."""
    found = {name: set(parser._option_string_actions)}
    for path, _, command in commands(parser, name):
        found[path] = set(command._option_string_actions)
    return found


KNOWN = _known(COMPANION, "companion") | _known(USVCTL, "usvctl")


def _spoken_fault(span: str) -> str | None:
    """What is wrong with a command that the prose mentions, perhaps without its arguments."""
    words = re.split(r"\s+", span)
    path = words[0]
    for word in words[1:]:
        if f"{path} {word}" not in KNOWN:
            break
        path = f"{path} {word}"
    rest = words[len(path.split()) :]
    below = [name for name in KNOWN if name.startswith(f"{path} ")]
    if below and rest and re.fullmatch(r"[a-z][a-z-]*", rest[0]):
        return f"no command {path} {rest[0]}"
    missing = [option for option in _OPTION.findall(" ".join(rest)) if option not in KNOWN[path]]
    return f"{path} has no {', '.join(missing)}" if missing else None


@pytest.mark.parametrize("path", written(), ids=label)
def test_every_command_in_the_prose_exists(path: Path) -> None:
    said = [span for span in spans(path) if re.match(r"(companion|usvctl)\s", span)]
    faults = [f"`{span}`: {fault}" for span in said if (fault := _spoken_fault(span))]
    assert not faults, f"{label(path)}: {'; '.join(faults)}"
