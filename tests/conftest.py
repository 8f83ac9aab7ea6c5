"""Settings that all tests share."""

import os
import sys

from hypothesis import settings

os.environ.setdefault("USV_NATIVE", "0")  # tests replace methods and count lines, which compiled modules do not have

# Each worker has one core: a second thread of the linear algebra would only wait for the other worker's.
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

# Without bytecode each process that a test starts compiles all modules anew, for longer than most of them run.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

settings.register_profile(
    "fixed", derandomize=True, deadline=None
)  # the same examples in every run, on machines of any speed
settings.load_profile("fixed")
