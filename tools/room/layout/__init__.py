"""Furnishing: which things stand where, on, in and under what, and how that changes."""
