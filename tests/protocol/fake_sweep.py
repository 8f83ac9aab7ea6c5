"""A sweep of fake sails in a process of its own."""

from __future__ import annotations

import functools
import sys
from pathlib import Path

from companion.cli.main import argument_parser
from companion.cli.sweep import sweep
from tests.unit.sitl.sweep.fake_sails import sweep_killing_sail


def main() -> int:
    """`python -m … MARKS FATAL ARGUMENTS`: a sweep of `sweep_killing_sail` in a process of its own."""
    marks, fatal, *words = sys.argv[1:]
    arguments = argument_parser().parse_args(words)
    return sweep(arguments, functools.partial(sweep_killing_sail, Path(marks), int(fatal)), lambda: False)


if __name__ == "__main__":
    sys.exit(main())
