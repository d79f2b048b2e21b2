"""Names given to things of the furnished room, without a network."""

import numpy as np

from sceneq_core.routing.revision import Revision
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.teaching.album import Album
from sceneq_core.teaching.book import BookParams, NameBook
from sceneq_core.teaching.evidence import Judgement
from sceneq_core.teaching.logistic import Logistic
from sceneq_core.teaching.reading import names_in, with_names
from sceneq_core.teaching.taught import Looks, Spot, Taught
from sceneq_core.teaching.wording import kind_of

from support.furnished import (
    ROOM,
    UP,
    Thing,
    WordEncoder,
    descriptors,
    furnish,
    instance,
    views,
)

NO_FEATURE = np.zeros(0, np.float32)
STAMP_NS = 1_795_363_500_000_000_000
JUDGEMENT = Judgement(alike=Logistic((20.0,), -14.0), again=Logistic((30.0, 6.0), -11.0))
"""Things with a cosine of 0.7 are as likely of one category as not."""


class TaughtRoom:
    """A furnished room and a book of names; ``seen`` is what questions see."""

    def __init__(self, things=ROOM, noise=0.3, judgement=JUDGEMENT, params=None) -> None:
        self.book = NameBook(params or BookParams())
        self.album = Album("words", judgement)
        self.map(things, noise)

    def map(self, things: tuple[Thing, ...], noise: float = 0.3, epoch: int = 5) -> None:
        """Let the room be ``things``, in the map of ``epoch``."""
        self.scene = furnish(things, noise)
        rows = descriptors(things, noise, seed=epoch)
        instances = [instance(i + 1, thing) for i, thing in enumerate(things)]
        self.scene.apply_map(Revision(epoch, 12, 110, 9_000), instances, UP, full=True)
        self.scene.apply_views(epoch, views(things))
        self.scene.apply_descriptors(epoch, rows, np.zeros(0, np.int32))
        self.album.put(epoch, {key: (row, NO_FEATURE) for key, row in rows.items()}, ())
        self.bare = self.scene.snapshot()
        self.book.settle(self.bare, self.album)

    def teach(self, instance_id: int, name: str, kind: str = "", by: str = "anna") -> Taught:
        """Give a name to an instance."""
        row = self.bare.find(instance_id)
        taught = Taught(
            number=self.book.next_number,
            name=name,
            kind=kind or kind_of(name),
            by=by,
            stamp_ns=STAMP_NS,
            spot=Spot.of(self.bare.instances[row].geometry, self.bare.revision.epoch),
            looks=self.album.looks_of(instance_id)
            or Looks("words", WordEncoder().encode_texts([name])[0], NO_FEATURE),
        )
        self.book.teach(taught)
        return taught

    @property
    def seen(self) -> SceneSnapshot:
        """What questions are answered from."""
        return with_names(self.bare, names_in(self.bare, self.book, self.album))

    def label(self, instance_id: int):
        """What an instance is called."""
        seen = self.seen
        return seen.instances[seen.find(instance_id)].label
