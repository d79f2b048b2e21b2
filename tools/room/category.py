"""What a kind of thing is called, made of and good for.

The roles, which composition places by (every library has at least one category of each):

- to sit and lie on: ``sofa``, ``armchair``, ``office_chair``, ``chair``, ``stool``, ``bed``
- to put things on: ``coffee_table``, ``dining_table``, ``desk``, ``nightstand``, ``tv_stand``
- to keep things in: ``bookcase``, ``dresser``, ``wardrobe``, ``filing_cabinet``
- of a kitchen row: ``kitchen_cabinet``, ``kitchen_sink``, ``stove``, ``refrigerator``,
  ``washing_machine`` on the floor; ``upper_cabinet`` and ``range_hood`` hang above them
- alone: ``television`` (stands on a ``tv_stand``), ``rug``, ``floor_lamp``, ``plant``
- small: ``top`` stands on any support, ``floor`` anywhere on the floor, ``floor_wall`` on the
  floor against a wall, ``wall`` hangs on a wall (its back, +y, to the wall)
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Category:
    """One label of the catalogue with the models that show it.

    Attributes:
        label: the name people use, such as ``coffee mug``.
        role: where it goes, one of the roles above.
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
