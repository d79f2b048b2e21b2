"""What a kind of thing is called, made of and good for."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Category:
    """One label of the catalogue with the models that show it.

    Attributes:
        label: the name people use, such as ``coffee mug``.
        role: where it goes: a furniture role (``sofa``, ``desk``, ``counter`` ...), ``top`` for small
            things on supports, ``floor`` or ``wall``.
        material: the obvious material word, such as ``wood``; ``""`` when there is none.
        affordances: what it is good for, as bare verb phrases (``drink from``).
        synonyms: other names that mean exactly this.
        models: stable model ids, never empty.
        tints: names in ``TINTS`` that its main surface may be painted with.
        repeats: whether a room usually holds several.
        scale: factor on the catalogue's size.
    """

    label: str
    role: str
    material: str
    affordances: tuple[str, ...]
    synonyms: tuple[str, ...]
    models: tuple[str, ...]
    tints: tuple[str, ...] = ()
    repeats: bool = False
    scale: float = 1.0
