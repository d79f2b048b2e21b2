"""An association that is shown views given as {superpoint: label}."""

import numpy as np

from sceneq_core.mapping.association import Association
from sceneq_core.mapping.association_params import AssociationParams
from sceneq_core.mapping.colours import NO_COLOURS, Colours
from sceneq_core.mapping.contacts import NO_CONTACTS, Contacts
from sceneq_core.mapping.superpoints import SuperpointChange
from sceneq_core.mapping.visibility import Visible

NO_IDS = np.zeros(0, np.int32)
NO_CHANGE = SuperpointChange(NO_IDS, NO_IDS, NO_IDS)
PIXELS = 30


def touching(*pairs):
    """Return contacts from (first, second, length of the border, unbent part of it)."""
    first, second, length, unbent = np.array(pairs).T
    return Contacts(
        first.astype(np.int32),
        second.astype(np.int32),
        length.astype(np.int64),
        unbent.astype(np.int64),
    )


def coloured(**colours):
    """Return colours from superpoints s0, s1, ... with the lightness of each, 100 voxels large."""
    lab = np.zeros((len(colours), 3), np.float32)
    lab[:, 0] = list(colours.values())
    superpoint_id = ids(*(int(name[1:]) for name in colours))
    return Colours(superpoint_id, lab, np.full(len(lab), 100, np.int64))


def ids(*values):
    """Return ids as the map holds them."""
    return np.array(values, np.int32)


class Film:
    """Feeds an association with views, one keyframe each; all superpoints come with the first."""

    def __init__(self, superpoints=4, **params):
        self.association = Association(AssociationParams(**params))
        self.superpoints = superpoints
        self.keyframe = 0

    def show(self, labels, change=None, entering=None, contacts=NO_CONTACTS, colours=NO_COLOURS):
        """Show a view {superpoint: label}; return what it did to the groups."""
        new = ids(*range(self.superpoints))
        first = SuperpointChange(new, np.full_like(new, -1), NO_IDS)
        change = change or (NO_CHANGE if self.keyframe else first)
        pixels = np.full(len(labels), PIXELS, np.int64)
        visible = Visible(ids(*labels), ids(*labels.values()), pixels, contacts, colours)
        result = self.association.update(change, visible, self.keyframe, entering)
        self.keyframe += 1
        return result

    def groups(self):
        """Return the group of every superpoint."""
        return self.association.of(np.arange(self.superpoints)).tolist()

    def partition(self):
        """Return the sets of superpoints that are in one group, as a set of frozensets."""
        groups = self.groups()
        return {
            frozenset(s for s, other in enumerate(groups) if other == group)
            for group in groups
            if group >= 0
        }
