"""The parts of a graph that answer questions, built once for an evaluation."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

from sceneq_core.encoding.describe import DescribeParams
from sceneq_core.encoding.encoder import Encoder
from sceneq_core.reasoning.reasoner import Reasoner
from sceneq_core.routing.router import Router, RouterParams
from sceneq_core.views.selector import ViewParams
from sceneq_nodes._backends import build
from sceneq_nodes._calibration import Calibration
from sceneq_nodes._chosen_calibration import chosen_calibration
from sceneq_nodes._ingesting import Spec
from sceneq_nodes._new_router import new_router
from sceneq_nodes._params import validate
from sceneq_nodes._routing_params import RoutingParams
from sceneq_nodes.encoding import EncodingParams
from sceneq_nodes.reasoning import ReasoningParams
from sceneq_nodes.views import ViewsParams
from sceneq_tools.errors import UserError
from sceneq_tools.graph import default_path, load
from sceneq_tools.graph_check import check_nodes

P = TypeVar("P")

USUAL_KEYFRAMES: Spec = {"kind": "interval"}


@dataclass(frozen=True, slots=True, eq=False)
class Setup:
    """Encoder, router and reasoner of a graph, and how its instances are seen and described.

    ``params``: of the router, as the graph says, before any calibration. ``read_ms`` remembers how
    long a question took to read for the first time, the only time that the text tower runs.
    """

    encoder: Encoder
    router: Router
    reasoner: Reasoner
    calibration: Calibration | None
    keyframes: Spec
    views: ViewParams
    describe: DescribeParams
    params: RouterParams = field(default_factory=RouterParams)
    read_ms: dict[str, float] = field(default_factory=dict)

    @property
    def tempered(self) -> Encoder:
        """The encoder with the temperature that the router uses."""
        return self.calibration.of_encoder(self.encoder) if self.calibration else self.encoder

    def seeing(self, every: int | None) -> "Setup":
        """Return the same with each so-manieth frame a keyframe; ``None`` = as the graph says."""
        return replace(self, keyframes={"kind": "every", "every": every}) if every else self

    def with_calibration(self, calibration: Calibration | None) -> "Setup":
        """Return the same with another calibration or none; ``ValueError`` as ``new_router``."""
        label_set = self.router.labeller.label_set
        calibrated = new_router(self.encoder, label_set, self.params, calibration)
        return replace(self, router=calibrated, calibration=calibration)

    def named(self) -> dict[str, str]:
        """Return what was used, for the head of a report."""
        return {
            "encoder": self.encoder.model_id,
            "reasoner": type(self.reasoner).__name__,
            "label_set": self.router.labeller.label_set.name,
            "temperature": f"{self.tempered.temperature:g}",
            "calibration": self.router.calibration,
        }


def open_setup(graph: Path | None = None, calibration: Path | None = None) -> Setup:
    """Return what the nodes of ``graph`` would build.

    ``calibration``: a file that replaces the graph's; "none" = no calibration.

    Raises:
        UserError: a graph or calibration that cannot be used.
    """
    loaded, document = load(graph or default_path())
    check_nodes(loaded, document)
    params = {node.node_kind: node.params for node in loaded.nodes}
    try:
        return _setup(params, calibration)
    except ValueError as error:
        raise UserError(str(error), 2) from error


def _setup(params: Mapping[str, Mapping[str, Any]], calibration: Path | None) -> Setup:
    """Build from the parameters of each kind of node."""
    routing = _validated(RoutingParams, params, "routing")
    encoding = _validated(EncodingParams, params, "encoding")
    reasoning = _validated(ReasoningParams, params, "reasoning")
    encoder: Encoder = build("encoder", encoding.encoder, ("encoder",))
    views = _validated(ViewsParams, params, "views")
    setting = str(calibration) if calibration else routing.calibration
    fitted = chosen_calibration(setting, encoder)
    return Setup(
        encoder=encoder,
        router=new_router(encoder, routing.chosen_labels(), routing.router, fitted),
        reasoner=build("reasoner", reasoning.reasoner, ("reasoner",)),
        calibration=fitted,
        keyframes=params.get("ingest", {}).get("keyframes", USUAL_KEYFRAMES),
        views=ViewParams(views.choice, views.archive),
        describe=encoding.describe,
        params=routing.router,
    )


def _validated(cls: type[P], params: Mapping[str, Mapping[str, Any]], kind: str) -> P:
    """Return the parameters of a node; of one that the graph lacks the usual ones."""
    return validate(cls, params.get(kind, {}), (kind,))
