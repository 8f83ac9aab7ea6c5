"""Integrity of the senses: hypotheses that a sensor lies, each tested against the others, and what follows.

`table.py` lists the hypotheses, `monitor.py` combines them, `evidence.py` is what they see.
"""
