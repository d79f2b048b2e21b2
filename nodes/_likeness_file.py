"""What the image vectors of an encoder are worth, measured: the file that passes names on.

JSON with ``format`` and ``encoders``: model id, or the start of one and ``*`` -> ``alike`` and
``again``, each ``weights`` and ``bias`` of a logistic, and what they were measured on.
``sceneq calibrate-names`` writes it.
"""

from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from sceneq_core.teaching.evidence import PLACE, Judgement
from sceneq_core.teaching.logistic import Logistic
from sceneq_nodes._json_fields import parse

FORMAT = "sceneq.likeness.v1"
SHIPPED = Path(__file__).parent / "likeness.json"


def judgement_of(model_id: str, path: str = "") -> Judgement:
    """Return what was measured for an encoder; nothing, when nothing was.

    Raises:
        ValueError: the file cannot be used; it is named.
    """
    file = Path(path) if path else SHIPPED
    try:
        encoders = _encoders(parse(file.read_bytes()))
        found = (encoders[key] for key in sorted(encoders) if fnmatchcase(model_id, key))
        return _judgement(next(found, {}))
    except OSError as error:
        raise ValueError(f"likeness: {file}: cannot be read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"likeness: {file}: {error!r:.120}") from error


def logistic_json(logistic: Logistic) -> dict[str, Any]:
    """Return what a file says of a logistic."""
    weights = [round(weight, 4) for weight in logistic.weights]
    return {"weights": weights, "bias": round(logistic.bias, 4)}


def _encoders(document: Any) -> Mapping[str, Any]:
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise ValueError(f"format: expected {FORMAT!r}")
    encoders: Mapping[str, Any] = document["encoders"]
    return encoders


def _judgement(measured: Mapping[str, Any]) -> Judgement:
    return Judgement(
        alike=_logistic(measured["alike"]) if "alike" in measured else None,
        again=_logistic(measured["again"]) if "again" in measured else None,
        place=_logistic(measured["place"]) if "place" in measured else PLACE,
    )


def _logistic(value: Mapping[str, Any]) -> Logistic:
    return Logistic(tuple(float(weight) for weight in value["weights"]), float(value["bias"]))
