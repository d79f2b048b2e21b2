"""Recordings in the layouts of other programs: one source a layout."""
