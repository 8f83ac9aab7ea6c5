"""Settings that all tests share."""

import os

from hypothesis import settings

os.environ.setdefault("USV_NATIVE", "0")  # tests replace methods and count lines, which compiled modules do not have

settings.register_profile(
    "fixed", derandomize=True, deadline=None
)  # the same examples in every run, on machines of any speed
settings.load_profile("fixed")
