"""Measures of a map and its answers against the truth: instances, ranking, calibration."""
