"""The result for other programs: one file per format, all from one saved or running scene."""
