"""A calibration on disk: temperature, "none of them" and thresholds that fit one encoder.

A JSON object with ``format``, ``encoder`` (the model id it was fitted for), ``temperature``,
``null`` (``NullParams``, or null where the data had nothing absent), ``null_described`` (the same
for words that describe a thing, null = as for names), ``sureness_described`` (of first guesses for
such words, null = as the softmax says), ``unfamiliar`` (all four again, for scenes that look unlike
what the encoder was taught with, and ``middle`` and ``slope`` of how that is told; null = alike),
``gate`` (the four thresholds), ``label_set``, ``sha256`` of the data, and whatever else its writer
tells.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any, TypeVar

from sceneq_core.arrays import Float32, Float64
from sceneq_core.checks import need_positive
from sceneq_core.encoding.encoder import Crop, Encoder
from sceneq_core.encoding.looks import familiarity
from sceneq_core.encoding.usual_sizes import sized
from sceneq_core.routing.gate import GateParams
from sceneq_core.routing.null import NullParams
from sceneq_core.routing.router import RouterParams
from sceneq_core.routing.sureness import Sureness
from sceneq_core.routing.unfamiliar import Unfamiliar
from sceneq_nodes._json_fields import parse

FORMAT = "sceneq.calibration.v5"
FORMER = {
    "sceneq.calibration.v1": "knows no 'none of them'",
    "sceneq.calibration.v2": "does not tell what is named from what is described",
    "sceneq.calibration.v3": "does not know how sure a first guess for a description is",
    "sceneq.calibration.v4": "does not tell familiar scenes from unfamiliar ones",
}
"""Formats that are no longer read, and what they lack."""
NO_CALIBRATION = "none"
MAKE = "sceneq calibrate"

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Calibration:
    """``temperature`` T of softmax(s / T), ``null`` and ``gate``, fitted for ``encoder``.

    ``null``: how probable "none of them" is; ``None`` = the data did not tell. ``null_described``:
    the same where words describe a thing, ``None`` = as where they name it;
    ``sureness_described``: how sure the first guess then is, ``None`` = as the softmax says.
    ``unfamiliar``: all this where things look unlike what the encoder was taught with, ``None`` =
    alike. ``label_set``: what the words competed with. ``sha256`` names the data it was fitted on,
    one digest a recording.
    """

    encoder: str
    temperature: float
    gate: GateParams
    null: NullParams | None = None
    label_set: str = ""
    sha256: tuple[str, ...] = ()
    null_described: NullParams | None = None
    sureness_described: Sureness | None = None
    unfamiliar: Unfamiliar | None = None

    def __post_init__(self) -> None:
        need_positive(self, "temperature")

    def as_dict(self) -> dict[str, Any]:
        """Return what the file holds at least."""
        return {
            "format": FORMAT,
            "encoder": self.encoder,
            "temperature": self.temperature,
            "null": _given(self.null),
            "null_described": _given(self.null_described),
            "sureness_described": _given(self.sureness_described),
            "unfamiliar": _given(self.unfamiliar),
            "gate": asdict(self.gate),
            "label_set": self.label_set,
            "sha256": list(self.sha256),
        }

    @property
    def name(self) -> str:
        """What answers call it: the encoder, and a fingerprint of all numbers and of the data."""
        content = json.dumps(self.as_dict(), sort_keys=True)
        return f"{self.encoder}:{hashlib.sha256(content.encode()).hexdigest()[:8]}"

    def of_router(self, params: RouterParams) -> RouterParams:
        """Return the parameters of a router with these thresholds and this "none of them"."""
        return replace(
            params,
            judge=replace(params.judge, gate=self.gate),
            null=self.null,
            null_described=self.null_described,
            sureness_described=self.sureness_described,
            unfamiliar=self.unfamiliar,
        )

    def of_encoder(self, encoder: Encoder) -> Encoder:
        """Return the encoder with this temperature.

        Raises:
            ValueError: it is another encoder: its cosines mean something else.
        """
        if encoder.model_id != self.encoder:
            raise ValueError(
                f"calibration: made for the encoder '{self.encoder}', this one is "
                f"'{encoder.model_id}' (make one for it: {MAKE})"
            )
        return Tempered(encoder, self.temperature)


class Tempered:
    """An encoder with another temperature."""

    def __init__(self, encoder: Encoder, temperature: float) -> None:
        self.model_id = encoder.model_id
        self.dim = encoder.dim
        self.temperature = temperature
        self.ceiling = encoder.ceiling
        self._encoder = encoder

    def encode_crops(self, crops: Sequence[Crop]) -> tuple[Float32, Float32]:
        """Return descriptors (N, dim) and features (N, F) of the encoder."""
        return self._encoder.encode_crops(crops)

    def sized(self, descriptor: Float32, shape: Float64) -> Float32:
        """Return the encoder's descriptor (D,) of a thing that has this shape (4,)."""
        return sized(self._encoder, descriptor, shape)

    def familiarity(self, feature: Float32) -> float:
        """Return how much an image feature (F,) is like what the encoder was taught, 1 = same."""
        return familiarity(self._encoder, feature)

    def encode_texts(self, texts: Sequence[str]) -> Float32:
        """Return (N, dim), L2-normalised."""
        return self._encoder.encode_texts(texts)


def read_calibration(path: Path) -> Calibration:
    """Return the calibration in a file; raise ``ValueError`` naming the file and what is wrong."""
    try:
        return _calibration(parse(path.read_bytes()))
    except OSError as error:
        raise ValueError(f"calibration: {path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise ValueError(f"calibration: {path}: {error}") from error


def _calibration(document: Any) -> Calibration:
    found = document.get("format") if isinstance(document, dict) else None
    if isinstance(found, str) and found in FORMER:
        raise ValueError(f"format: {found!r} {FORMER[found]} (make a new one: {MAKE})")
    if not isinstance(document, dict) or found != FORMAT:
        raise ValueError(f"format: expected {FORMAT!r} (sceneq calibrate writes one)")
    encoder, gate = document.get("encoder"), document.get("gate")
    if not isinstance(encoder, str):
        raise ValueError(f"encoder: expected the id of a model, got {encoder!r}")
    if not isinstance(gate, dict):
        raise ValueError(f"gate: expected its thresholds, got {gate!r}")
    sha256 = document.get("sha256", [])
    if not isinstance(sha256, list):
        raise ValueError(f"sha256: expected a list, got {sha256!r}")
    return Calibration(
        encoder=encoder,
        temperature=_number(document, "temperature"),
        gate=GateParams(**_numbers(gate, GateParams, "gate.")),
        label_set=str(document.get("label_set", "")),
        sha256=tuple(map(str, sha256)),
        unfamiliar=_unfamiliar(document),
        **_nulls(document),
    )


def _nulls(document: Mapping[str, Any], where: str = "") -> dict[str, Any]:
    """Return what a calibration has beside its temperature, for one kind of scenes."""
    return {
        "null": _optional(document, "null", NullParams, "'none of them'", where),
        "null_described": _optional(
            document, "null_described", NullParams, "'none of them'", where
        ),
        "sureness_described": _optional(
            document, "sureness_described", Sureness, "a first guess", where
        ),
    }


def _unfamiliar(document: Mapping[str, Any]) -> Unfamiliar | None:
    given = document.get("unfamiliar", "missing")
    if given is None:
        return None
    if not isinstance(given, dict):
        raise ValueError(f"unfamiliar: expected the numbers of unfamiliar scenes, got {given!r}")
    where = "unfamiliar."
    return Unfamiliar(
        temperature=_number(given, "temperature", where),
        middle=_number(given, "middle", where),
        slope=_number(given, "slope", where),
        **_nulls(given, where),
    )


def _optional(
    document: Mapping[str, Any], name: str, cls: type[T], of: str, where: str = ""
) -> T | None:
    """Return the numbers of ``cls`` under a name, ``None`` for null."""
    given = document.get(name, "missing")
    if given is None:
        return None
    if not isinstance(given, dict):
        raise ValueError(f"{where}{name}: expected the numbers of {of}, got {given!r}")
    return cls(**_numbers(given, cls, f"{where}{name}."))


def _given(part: Any) -> dict[str, Any] | None:
    return None if part is None else asdict(part)


def _numbers(values: Mapping[str, Any], cls: type, where: str) -> dict[str, float]:
    return {field.name: _number(values, field.name, where) for field in fields(cls)}


def _number(values: Mapping[str, Any], name: str, where: str = "") -> float:
    value = values.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{where}{name}: expected a number, got {value!r}")
    return float(value)
