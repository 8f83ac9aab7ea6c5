"""Sweeps: a design of experiments over scenarios, sailed on many cores, a row of figures a run."""
