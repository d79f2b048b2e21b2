"""The descriptor of an instance: the mean of its crops over views and levels."""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock

import numpy as np

from sceneq_core.arrays import Float32, UInt8
from sceneq_core.checks import need_at_least, need_within
from sceneq_core.encoding.encoder import Encoder
from sceneq_core.encoding.joint import unit
from sceneq_core.encoding.pending import view_key
from sceneq_core.encoding.pyramid import pyramid
from sceneq_core.views.view import View, ViewSet

Image = Callable[[View], UInt8 | None]
"""View -> the colours (H, W, 3) of its keyframe, ``None`` when they are gone."""


@dataclass(frozen=True, slots=True)
class DescribeParams:
    """How an instance is cropped.

    ``levels`` crops a view, each ``expand`` (of the box edge) larger than the one before;
    ``remembered`` views whose crops are not encoded again while they stay in a view set.
    """

    levels: int = 3
    expand: float = 0.2
    remembered: int = 4096

    def __post_init__(self) -> None:
        need_within(self, 1, 8, "levels")
        need_within(self, 0, 2, "expand")
        need_at_least(self, 1, "remembered")


@dataclass(frozen=True, slots=True)
class Description:
    """``descriptor`` (D,) and ``feature`` (F,) of length 1, from the views ``view_seq``."""

    descriptor: Float32
    feature: Float32
    view_seq: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class _Seen:
    """Mean descriptor and mean feature over the levels of one view."""

    descriptor: Float32
    feature: Float32


class Describer:
    """Describes view sets. The result depends on the view set only, not on what came before.

    Several threads may describe at a time, if the encoder lets them.
    """

    def __init__(self, encoder: Encoder, params: DescribeParams) -> None:
        self._encoder = encoder
        self._params = params
        self._seen: OrderedDict[tuple[int, int, bytes, bytes], _Seen] = OrderedDict()
        self._lock = Lock()

    def describe(self, view_set: ViewSet, image: Image) -> Description | None:
        """Return the description, ``None`` when no view of the set has an image any more.

        Multi-level crops of the top-k views, their mean, L2-normalised (A. Takmaz et al.,
        OpenMask3D, NeurIPS 2023, doi 10.48550/arXiv.2306.13631).
        """
        found = [
            (view.seq, seen)
            for view in sorted(view_set.views, key=lambda view: view.seq)
            if (seen := self._look(view, image)) is not None
        ]
        if not found:
            return None
        return Description(
            descriptor=unit(np.mean([seen.descriptor for _, seen in found], axis=0)),
            feature=unit(np.mean([seen.feature for _, seen in found], axis=0)),
            view_seq=tuple(seq for seq, _ in found),
        )

    def _look(self, view: View, image: Image) -> _Seen | None:
        key = (*view_key(view), np.packbits(view.mask).tobytes())
        with self._lock:
            if key in self._seen:
                self._seen.move_to_end(key)
                return self._seen[key]
        rgb = image(view)
        if rgb is None:
            return None
        seen = self._encode(rgb, view)
        with self._lock:
            self._seen[key] = seen
            if len(self._seen) > self._params.remembered:
                self._seen.popitem(last=False)
        return seen

    def _encode(self, rgb: UInt8, view: View) -> _Seen:
        crops = pyramid(rgb, view, self._params.levels, self._params.expand)
        descriptors, features = self._encoder.encode_crops(crops)
        return _Seen(descriptors.mean(axis=0), features.mean(axis=0))
