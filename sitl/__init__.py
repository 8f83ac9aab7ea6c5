"""The simulated boat."""

import companion  # noqa: F401  # so that no module of this package is imported before the compiled ones can be
