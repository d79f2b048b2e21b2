"""A router from its parameters, for the node and for whoever measures it."""

from sceneq_core.encoding.encoder import Encoder
from sceneq_core.routing.labels import Labeller, LabelSet
from sceneq_core.routing.likelihood import FIXED_TEXTS
from sceneq_core.routing.router import Router, RouterParams
from sceneq_nodes._calibration import Calibration
from sceneq_nodes._known_texts import KnownTexts


def new_router(
    encoder: Encoder,
    label_set: LabelSet,
    params: RouterParams,
    calibration: Calibration | None = None,
) -> Router:
    """Return a router that knows the vectors of its labels at once.

    Raises:
        ValueError: the calibration was made for another encoder.
    """
    known: Encoder = KnownTexts(encoder, (*label_set.labels, *FIXED_TEXTS))
    if calibration is None:
        return Router(params, known, Labeller(label_set, known))
    known, params = calibration.of_encoder(known), calibration.of_router(params)
    return Router(params, known, Labeller(label_set, known), calibration.name)
