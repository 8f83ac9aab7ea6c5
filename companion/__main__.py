"""The program: `companion`, or `python -m companion`."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence

_INTERRUPTED = 130  # as shells have it: 128 and the number of SIGINT
_IN_TIME = ("run", "leader")  # commands that tick
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def main() -> int:
    """Carry out the command of the process's arguments. Returns its exit code."""
    try:
        return _carried_out()
    except KeyboardInterrupt:  # of a command that does not end in an order of its own
        sys.stderr.write("companion: ended by Ctrl-C\n")
        return _INTERRUPTED


def _carried_out() -> int:
    spare_threads(sys.argv[1:])
    gc.disable()  # modules make no garbage, and what they make stays: without looking they load a tenth faster
    from companion.cli.main import carry_out, parsed

    arguments = parsed(sys.argv[1:])
    gc.freeze()
    gc.enable()
    return carry_out(arguments)


def spare_threads(words: Sequence[str]) -> None:
    """Let numerical libraries, which read it as they are loaded, compute with one thread where a tick waits for them:
    several wait for one another, for seconds where other programs compute, too."""
    if words and words[0] in _IN_TIME:
        for name in _THREADS:
            os.environ.setdefault(name, "1")


if __name__ == "__main__":
    sys.exit(main())
