"""Recordings as an encoder would describe them that was not taught with their furniture.

Rooms of ``sceneq synth`` are made of the models that the encoder was taught with, so that what is
fitted there is true of no other house. Here every thing is described by a probe that was taught
without its model: cross-validation by model, as for any calibration (A. Niculescu-Mizil and R.
Caruana, "Predicting good probabilities with supervised learning", ICML 2005, DOI
10.1145/1102351.1102430).
"""

import json
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from sceneq_core.arrays import Float32, Int64
from sceneq_core.routing.columns import Columns
from sceneq_core.routing.row_blocks import RowBlocks
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_nodes._probe_file import read_probe
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.calibration import Scene
from sceneq_tools.evaluation.retrieval_candidates import Candidates
from sceneq_tools.evaluation.retrieval_setup import Setup, open_setup
from sceneq_tools.evaluation.true_things import THINGS_FILE
from sceneq_tools.graph import default_path, load

OVERLAPS = tuple(round(0.05 * step, 2) for step in range(1, 20))
"""What an instance of a map shows is the thing that it overlaps most."""
OTHER_NAMES = "probes of other names than that of the graph's encoder"
STRANGE = -1.0
"""The familiarity of what nobody is a stranger to: it does not make a scene look familiar."""
HINT = "make it with: sceneq train-probe --withhold"
SPEAKING = ("encoding", "routing")
"""Nodes that have to agree on an encoder."""


@dataclass(frozen=True, slots=True, eq=False)
class Stranger:
    """An encoder that was not taught with the models ``withheld``, and the graph that has it."""

    withheld: frozenset[str]
    setup: Setup
    graph: Path


def open_strangers(probes: Path, graph: Path | None, out: Path) -> list[Stranger]:
    """Return the strangers in a folder of probes; their graphs are written to ``out``.

    Raises:
        UserError: there is none, or a file is not of ``sceneq train-probe --withhold``.
    """
    files = sorted(probes.resolve().glob("*.npz"))
    if not files:
        raise UserError(f"{probes}: no .npz file in it ({HINT})", 2)
    return [_open(file, graph, out / f"{file.stem}.yaml") for file in files]


def _open(probe: Path, graph: Path | None, out: Path) -> Stranger:
    try:
        withheld = read_probe(probe).withheld
    except ValueError as error:
        raise UserError(str(error), 2) from error
    if not withheld:
        raise UserError(f"{probe}: it was taught with everything ({HINT})", 2)
    out.write_text(yaml.safe_dump(_with_probe(graph or default_path(), probe)))
    return Stranger(frozenset(withheld), open_setup(out, Path("none")), out)


def _with_probe(graph: Path, probe: Path) -> dict[str, Any]:
    """Return a graph whose encoder has this probe."""
    document: dict[str, Any] = deepcopy(load(graph)[1].values)
    for node in document["nodes"]:
        if node.get("kind", node["id"]) in SPEAKING:
            node["params"] = {**node.get("params", {}), **_encoder(probe)}
            node["params"].pop("calibration", None)
    return document


def _encoder(probe: Path) -> dict[str, Any]:
    return {"encoder": {"kind": "conse", "probe": str(probe)}}


def strange_scenes(
    known: Sequence[Scene], strange: Sequence[tuple[Stranger, Sequence[Scene]]]
) -> tuple[Scene, ...]:
    """Return ``known`` as described by strangers; of each there are the same scenes.

    Raises:
        UserError: they are not the same.
    """
    found = []
    for number, scene in enumerate(known):
        parts = [(who.withheld, scenes[number].candidates) for who, scenes in strange]
        own = scene.candidates
        models, shown = models_of(scene.questioned.folder), closest_things(own)
        by_candidate = {key: models[thing] for key, thing in shown.items() if thing in models}
        found.append(Scene(scene.questioned, estranged(own, parts, by_candidate)))
    return tuple(found)


def models_of(recording: Path) -> dict[int, str]:
    """Return the furniture that each true thing is a copy of; what is of no model is left out."""
    records = json.loads((recording / THINGS_FILE).read_text())["instances"]
    return {int(one["id"]): str(one["model"]) for one in records if one.get("model")}


def closest_things(candidates: Candidates) -> dict[int, int]:
    """Return the true thing that each candidate is most like, by the strictest rule that holds.

    The rules of ``candidates.matches`` go from lax to strict.
    """
    return {
        key: thing
        for matches in candidates.matches.values()
        for thing, keys in matches.items()
        for key in sorted(keys)
    }


def estranged(
    known: Candidates,
    strange: Sequence[tuple[frozenset[str], Candidates]],
    models: Mapping[int, str],
) -> Candidates:
    """Return the candidates, each as described by who was not taught with its model.

    ``models`` by the id of a candidate; ``strange`` are the same candidates as described by others,
    and what these were not taught with. What nobody is a stranger to stays as it is, and does not
    make the scene look familiar.

    Raises:
        UserError: other candidates, or vectors of another length.
    """
    ids = known.snapshot.columns.instance_id
    owner = np.array([_owner(models.get(int(key), ""), strange) for key in ids], np.int64)
    snapshots = [known.snapshot, *(one.snapshot for _, one in strange)]
    for other in snapshots[1:]:
        if not _comparable(known.snapshot, other):
            raise UserError(f"strangers: other instances, or {OTHER_NAMES}", 2)
    return replace(known, snapshot=_chosen(snapshots, owner))


def _owner(model: str, strange: Sequence[tuple[frozenset[str], Candidates]]) -> int:
    """Return 1 + the number of the one that was not taught with a model, 0 = there is none."""
    return next((n for n, (withheld, _) in enumerate(strange, 1) if model in withheld), 0)


def _comparable(one: SceneSnapshot, other: SceneSnapshot) -> bool:
    same_shapes = all(
        getattr(one, name).shape == getattr(other, name).shape
        for name in ("descriptors", "label_scores")
    )
    return same_shapes and np.array_equal(one.columns.instance_id, other.columns.instance_id)


def _chosen(snapshots: Sequence[SceneSnapshot], owner: Int64) -> SceneSnapshot:
    """Return a snapshot whose row i is that of ``snapshots[owner[i]]``."""

    def rows(parts: Sequence[Float32]) -> Float32:
        chosen: Float32 = np.stack(parts)[owner, np.arange(len(owner))]
        return chosen

    def blocks(name: str) -> RowBlocks:
        whole = rows([np.asarray(getattr(one, name)) for one in snapshots])
        return RowBlocks([whole], whole.shape[1])

    def column(name: str) -> Float32:
        return rows([getattr(one.columns, name) for one in snapshots])

    columns: Columns = replace(
        snapshots[0].columns,
        label_mean=column("label_mean"),
        colour_scores=column("colour_scores"),
        familiarity=np.where(owner > 0, column("familiarity"), np.float32(STRANGE)),
    )
    return replace(
        snapshots[0],
        instances=tuple(snapshots[n].instances[row] for row, n in enumerate(owner.tolist())),
        columns=columns,
        descriptors=blocks("descriptors"),
        label_scores=blocks("label_scores"),
    )
