"""command-line.md: every command and option, from the parsers that the commands use."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from companion.cli.main import argument_parser
from docs.generate.markdown import code, page, section, sentence, table
from gcs_plugins.usvctl.cli import argument_parser as usvctl_parser

_INTRODUCTION = """`companion` is the program on the boat and its tools. `usvctl` commands a boat from a terminal.

Exit codes of `companion`: 0 done, 1 a check failed, 2 a mistake in the command or its files, 3 the computer does not
have a link's own address, or not yet."""


_USUAL = {  # of arguments that mean the same everywhere and bring no text of their own
    "vessel": "A bundled name or a TOML file",
    "wind": "True wind and where it comes from; without a direction the seed gives one",
    "current": "Current and where it goes; without a direction the seed gives one",
    "fault": "A fault at a time, for a while or to the end",
    "seed": "Seed of all noise",
    "seeds": "How many seeds, from 0",
    "folder": "A log folder",
    "file": "A file",
    "changes": "A setting of the scenario, instead of its default",
    "dir": "Folder to write to",
    "to": "End of the part that counts",
}


def command_line() -> str:
    """The page."""
    return page(
        "Command line", _INTRODUCTION, *_sections(argument_parser(), "companion"), *_sections(usvctl_parser(), "usvctl")
    )


def _sections(parser: argparse.ArgumentParser, name: str) -> Iterator[str]:
    yield section(2, code(name), sentence(parser.description or ""), _arguments(parser), _commands(parser))
    for path, text, command in commands(parser, name):
        if not list(_subparsers(command)):
            yield section(
                3,
                code(path),
                sentence(text[:1].upper() + text[1:]),
                f"```text\n{usage(path, command)}\n```",
                _arguments(command),
            )


def commands(parser: argparse.ArgumentParser, name: str) -> Iterator[tuple[str, str, argparse.ArgumentParser]]:
    """Every command below a parser: its words, its help, its own parser."""
    for action in _subparsers(parser):
        helps = {choice.dest: choice.help or "" for choice in action._get_subactions()}
        for word, below in action.choices.items():
            yield f"{name} {word}", helps.get(word, ""), below
            yield from commands(below, f"{name} {word}")


def _subparsers(parser: argparse.ArgumentParser) -> Iterator[argparse._SubParsersAction[argparse.ArgumentParser]]:
    return (action for action in parser._actions if isinstance(action, argparse._SubParsersAction))


def _commands(parser: argparse.ArgumentParser) -> str:
    leaves = [(path, text) for path, text, command in commands(parser, parser.prog) if not list(_subparsers(command))]
    return table(("command", "what it does"), ((code(path), text) for path, text in leaves))


def usage(path: str, parser: argparse.ArgumentParser) -> str:
    """The command with its arguments on one line, options in brackets."""
    options = [f"[{_option(action)}]" for action in _own(parser) if action.option_strings]
    places = [_place(action) for action in _own(parser) if not action.option_strings]
    return " ".join([path, *places, *options])


def _own(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    skipped = (argparse._HelpAction, argparse._SubParsersAction)
    return (
        action for action in parser._actions if not isinstance(action, skipped) and action.help != argparse.SUPPRESS
    )


def _option(action: argparse.Action) -> str:
    value = "" if action.nargs == 0 else f" {_value(action)}"
    return f"{action.option_strings[-1]}{value}"


def _place(action: argparse.Action) -> str:
    value = _value(action)
    return {"?": f"[{value}]", "*": f"[{value} …]", "+": f"{value} …"}.get(str(action.nargs), value)


def _value(action: argparse.Action) -> str:
    if isinstance(action.metavar, tuple):
        return " ".join(action.metavar)
    if action.metavar is not None:
        return action.metavar
    if action.choices is not None:
        return "|".join(str(choice) for choice in action.choices)
    return action.dest.upper()


def _arguments(parser: argparse.ArgumentParser) -> str:
    rows = []
    for action in _own(parser):
        shown = _option(action) if action.option_strings else _place(action)
        several = " Can be given several times." if isinstance(action, argparse._AppendAction) else ""
        rows.append((code(shown), sentence(_help(action)) + several, _default(action)))
    return table(("argument", "meaning", "default"), rows)


def _help(action: argparse.Action) -> str:
    text = (action.help or _USUAL.get(action.dest, "")).replace("%%", "%")
    return text.replace(" (%(default)s)", "").replace(" (%(default)g)", "")


def _default(action: argparse.Action) -> str:
    value = action.default
    empty = value in (None, [], False, argparse.SUPPRESS) or value != value  # NaN: not given
    return "" if empty or action.nargs == 0 else code(action.default)
