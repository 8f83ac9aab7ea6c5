"""Compiles the arithmetic of the boat and of its simulation: `python -m sitl.native`. The .py files stay the source."""
