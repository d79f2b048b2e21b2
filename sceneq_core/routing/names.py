"""Names that were taught, as they stand in one snapshot: what questions and answers see of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from sceneq_core.routing.labels import Label
from sceneq_core.teaching.wording import speaks, spoken

SURE = 0.9
"""Below this probability an answer says how sure it is that a name is still that of the thing."""


@dataclass(frozen=True, slots=True)
class GivenName:
    """A taught name and the rows that it means.

    ``p``: row -> probability that the thing is called so. Empty: nothing in this map is what was
    taught (any more), or, ``waiting``, it cannot be answered with yet. ``told`` says by whom and
    when, in words. ``maybe``: rows that are alike, but not enough to be called so.
    """

    name: str
    told: str
    p: Mapping[int, float]
    maybe: Mapping[int, float] = field(default_factory=dict)
    waiting: bool = False

    @property
    def reason(self) -> str:
        """Why an answer is what it is, or why the name was of no use."""
        if self.p:
            surest = max(self.p.values())
            doubt = f", this is it with p {surest:.2f}" if surest < SURE else ""
            return f"'{self.name}' was {self.told}{doubt}"
        gone = "nothing in this map is that now"
        why = "it was not seen well enough yet" if self.waiting else gone
        return f"'{self.name}' was {self.told}, but {why}"


@dataclass(frozen=True, slots=True)
class Names:
    """All taught names of a snapshot.

    ``given``: what a question asks for when it speaks the name -> the names, newest first.
    ``called``: row -> what it is called, best first; ``like``: what it is only like.
    """

    given: Mapping[str, tuple[GivenName, ...]] = field(default_factory=dict)
    called: Mapping[int, tuple[Label, ...]] = field(default_factory=dict)
    like: Mapping[int, tuple[Label, ...]] = field(default_factory=dict)

    def meant(self, thing: str, text: str) -> GivenName | None:
        """Return the name that ``thing`` in a question ``text`` is, if it is one.

        Of "my mug" a question leaves "mug": then the question must have said "my" as well.
        """
        for one in self.given.get(thing, ()):
            if spoken(one.name) == thing or speaks(text, one.name):
                return one
        return None

    def reason(self, name: str) -> str:
        """Say who gave a name, and when."""
        given = (one for names in self.given.values() for one in names if one.name == name)
        return next((one.reason for one in given), "")


NO_NAMES = Names()
