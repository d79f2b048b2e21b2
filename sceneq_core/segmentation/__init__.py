"""Class-agnostic 2D segments of one frame."""
