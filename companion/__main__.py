"""The program: `companion`, or `python -m companion`."""

from __future__ import annotations

import gc
import sys

_INTERRUPTED = 130  # as shells have it: 128 and the number of SIGINT


def main() -> int:
    """Carry out the command of the process's arguments. Returns its exit code."""
    try:
        return _carried_out()
    except KeyboardInterrupt:  # of a command that does not end in an order of its own
        sys.stderr.write("companion: ended by Ctrl-C\n")
        return _INTERRUPTED


def _carried_out() -> int:
    gc.disable()  # modules make no garbage, and what they make stays: without looking they load a tenth faster
    from companion.cli.main import carry_out, parsed

    arguments = parsed(sys.argv[1:])
    gc.freeze()
    gc.enable()
    return carry_out(arguments)


if __name__ == "__main__":
    sys.exit(main())
