"""Cameras on this machine: one source a maker, each with the package of that maker."""
