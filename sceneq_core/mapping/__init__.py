"""Voxels, superpoints and instances from posed frames with 2D segments."""
