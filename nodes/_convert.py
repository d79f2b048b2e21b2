"""Core types <-> messages. Both sides share field names on purpose, so most of it is copying."""

from collections.abc import Iterable
from dataclasses import fields
from typing import Any, TypeVar

import numpy as np

from sceneq_core.arrays import Bool
from sceneq_core.mapping.delta import Event, Instance, MapDelta, Place
from sceneq_core.mapping.proposals import Proposals
from sceneq_core.views.view import View, ViewSet
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.map import Event as EventMessage
from sceneq_schemas.map import Instance as InstanceMessage
from sceneq_schemas.map import MapDelta as MapDeltaMessage
from sceneq_schemas.map import Place as PlaceMessage
from sceneq_schemas.proposal import ProposalSet
from sceneq_schemas.view import View as ViewMessage
from sceneq_schemas.view import ViewSet as ViewSetMessage

C = TypeVar("C")
MAX_MASK_SIDE = 16_384


def map_delta_message(delta: MapDelta, epoch: int, seq: int) -> MapDeltaMessage:
    """Return ``delta`` as the ``seq``-th message of ``epoch``."""
    instances = tuple(
        _copy(InstanceMessage, instance, places=_copies(PlaceMessage, instance.places))
        for instance in delta.instances
    )
    events = _copies(EventMessage, delta.events)
    return _copy(MapDeltaMessage, delta, epoch=epoch, seq=seq, instances=instances, events=events)


def map_delta_from_message(message: MapDeltaMessage) -> MapDelta:
    """Return the change of the map in ``message``; its place in the epoch stays behind."""
    instances = tuple(
        _copy(Instance, instance, places=_copies(Place, instance.places))
        for instance in message.instances
    )
    return _copy(MapDelta, message, instances=instances, events=_copies(Event, message.events))


def proposal_message(proposals: Proposals, source: str) -> ProposalSet:
    """Return ``proposals`` as somebody called ``source`` would send them."""
    return _copy(ProposalSet, proposals, stamp_ns=0, source=source)


def view_set_message(view_set: ViewSet) -> ViewSetMessage:
    """Return ``view_set`` with its masks packed to bits, row by row."""
    return ViewSetMessage(
        view_set.instance_id,
        tuple(
            _copy(
                ViewMessage,
                view,
                mask_shape=view.mask.shape,
                mask_bits=np.packbits(view.mask, axis=1).tobytes(),
            )
            for view in view_set.views
        ),
    )


def view_set_from_message(message: ViewSetMessage) -> ViewSet:
    """Return the view set in ``message``.

    Raises:
        DecodeError: mask bytes that do not match the mask's shape.
    """
    views = tuple(_copy(View, view, mask=_unpack_mask(view)) for view in message.views)
    return ViewSet(message.instance_id, views)


def _copy(cls: type[C], source: Any, /, **changes: Any) -> C:
    """Return a ``cls`` with ``changes`` and, for its other fields, those of ``source``."""
    names = [f.name for f in fields(cls) if f.name not in changes]  # type: ignore[arg-type]
    return cls(**{name: getattr(source, name) for name in names}, **changes)


def _copies(cls: type[C], sources: Iterable[Any]) -> tuple[C, ...]:
    return tuple(_copy(cls, source) for source in sources)


def _unpack_mask(view: ViewMessage) -> Bool:
    shape, bits = view.mask_shape, view.mask_bits
    if len(shape) != 2 or not all(0 <= side <= MAX_MASK_SIDE for side in shape):
        raise DecodeError(f"View.mask_shape: {shape!r:.60}")
    row_bytes = -(-shape[1] // 8)
    if len(bits) != shape[0] * row_bytes:
        raise DecodeError(f"View.mask_bits: {len(bits)} bytes for a mask of shape {shape}")
    rows = np.frombuffer(bits, np.uint8).reshape(shape[0], row_bytes)
    return np.unpackbits(rows, axis=1, count=shape[1]).astype(np.bool_)
