"""Settings that all tests share."""

from hypothesis import settings

settings.register_profile(
    "fixed", derandomize=True, deadline=None
)  # the same examples in every run, on machines of any speed
settings.load_profile("fixed")
