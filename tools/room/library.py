"""The seam between rooms and where their models come from."""

from typing import Protocol

from sceneq_tools.room.category import Category
from sceneq_tools.room.mesh import Mesh


class Library(Protocol):
    """Named models of household things.

    ``name`` says which library it is, for instances.json and for people.
    """

    name: str

    def categories(self) -> tuple[Category, ...]:
        """Return every category there are models for, in a fixed order."""

    def mesh(self, model_id: str, scale: float = 1.0, tint: str | None = None) -> Mesh:
        """Return the model in its own frame, its main surface painted when tinted; cached.

        Raises:
            ValueError: no such model or tint, or a file that cannot be read; names both.
        """

    def attribution(self, model_id: str) -> str:
        """Return name, author and licence in one line; "" when nothing has to be said."""
