"""Pictures of a scene without a display."""

from sceneq_core.picture.colours import instance_colours

__all__ = ["instance_colours"]
