"""The program: `companion`, or `python -m companion`."""

from __future__ import annotations

import gc
import sys


def main() -> int:
    """Carry out the command of the process's arguments. Returns its exit code."""
    gc.disable()  # modules make no garbage, and what they make stays: without looking they load a tenth faster
    from companion.cli.main import carry_out, parsed

    arguments = parsed(sys.argv[1:])
    gc.freeze()
    gc.enable()
    return carry_out(arguments)


if __name__ == "__main__":
    sys.exit(main())
