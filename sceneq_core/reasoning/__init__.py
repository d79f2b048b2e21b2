"""Slower, better answers over a few candidates."""
