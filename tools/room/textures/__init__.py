"""Painted surfaces: floors, walls, cloth, pictures, the view from the window."""
