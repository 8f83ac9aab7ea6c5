"""`python -m sitl.native`."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
import sysconfig

from companion.native import ROOT
from sitl.native.build import BuildError, build


def main() -> int:
    """The command. Returns its exit code."""
    parser = argparse.ArgumentParser(prog="python -m sitl.native", description="Compile the arithmetic.")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="compilers at a time (all cores)")
    parser.add_argument("--cc", default=sysconfig.get_config_var("CC") or "cc", help="the C compiler (Python's own)")
    arguments = parser.parse_args()
    try:
        library = build(ROOT / "build" / "native", shlex.split(arguments.cc), max(1, arguments.jobs))
    except BuildError as error:
        print(error, file=sys.stderr)
        return 1
    print(f"{library}: {library.stat().st_size / 1e6:.0f} MB")
    return 0


raise SystemExit(main())
