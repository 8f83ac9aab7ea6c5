"""Measured tables: what to sail, the figures, and the program that measures them."""
