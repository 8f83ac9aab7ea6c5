"""The fault matrix: every fault in every mode on every bundled vessel, and the reaction that is expected.

`expected.toml` is the table; the tests and the documentation's page read it. `stages.py` brings a vessel into a mode,
`deeds.py` begins a fault, `cell.py` judges what happens.
"""
