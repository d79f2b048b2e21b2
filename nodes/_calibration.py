"""A calibration on disk: the temperature and the thresholds that fit one encoder.

A JSON object with ``format``, ``encoder`` (the model id it was fitted for), ``temperature``,
``gate`` (the four thresholds), ``sha256`` of the data, and whatever else its writer tells.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

from sceneq_core.arrays import Float32
from sceneq_core.checks import need_positive
from sceneq_core.encoding.encoder import Crop, Encoder
from sceneq_core.routing.gate import GateParams
from sceneq_core.routing.router import RouterParams

FORMAT = "sceneq.calibration.v1"


@dataclass(frozen=True, slots=True)
class Calibration:
    """``temperature`` T of softmax(s / T) and thresholds ``gate``, fitted for ``encoder``.

    ``sha256`` names the data it was fitted on, one digest a recording.
    """

    encoder: str
    temperature: float
    gate: GateParams
    sha256: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        need_positive(self, "temperature")

    def as_dict(self) -> dict[str, Any]:
        """Return what the file holds at least."""
        return {
            "format": FORMAT,
            "encoder": self.encoder,
            "temperature": self.temperature,
            "gate": asdict(self.gate),
            "sha256": list(self.sha256),
        }

    def of_router(self, params: RouterParams) -> RouterParams:
        """Return the parameters of a router with these thresholds."""
        return replace(params, judge=replace(params.judge, gate=self.gate))

    def of_encoder(self, encoder: Encoder) -> Encoder:
        """Return the encoder with this temperature.

        Raises:
            ValueError: it is another encoder: its cosines mean something else.
        """
        if encoder.model_id != self.encoder:
            raise ValueError(
                f"calibration: made for the encoder '{self.encoder}', this one is "
                f"'{encoder.model_id}' (make one for it: sceneq calibrate)"
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

    def encode_texts(self, texts: Sequence[str]) -> Float32:
        """Return (N, dim), L2-normalised."""
        return self._encoder.encode_texts(texts)


def given_calibration(path: str) -> Calibration | None:
    """Return the calibration that a parameter names, ``None`` for ""; errors as below."""
    return read_calibration(Path(path)) if path else None


def fitting(calibration: Calibration | None, encoder: Encoder) -> Calibration | None:
    """Return the calibration if it was made for ``encoder``."""
    return calibration if calibration and calibration.encoder == encoder.model_id else None


def read_calibration(path: Path) -> Calibration:
    """Return the calibration in a file; raise ``ValueError`` naming the file and what is wrong."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        return _calibration(document)
    except OSError as error:
        raise ValueError(f"calibration: {path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise ValueError(f"calibration: {path}: {error}") from error


def _calibration(document: Any) -> Calibration:
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise ValueError(f"format: expected {FORMAT!r} (sceneq calibrate writes one)")
    encoder, gate = document.get("encoder"), document.get("gate")
    if not isinstance(encoder, str):
        raise ValueError(f"encoder: expected the id of a model, got {encoder!r}")
    if not isinstance(gate, dict):
        raise ValueError(f"gate: expected its thresholds, got {gate!r}")
    limits = {field.name: _number(gate, field.name, "gate.") for field in fields(GateParams)}
    sha256 = document.get("sha256", [])
    if not isinstance(sha256, list):
        raise ValueError(f"sha256: expected a list, got {sha256!r}")
    temperature = _number(document, "temperature")
    return Calibration(encoder, temperature, GateParams(**limits), tuple(map(str, sha256)))


def _number(values: Mapping[str, Any], name: str, where: str = "") -> float:
    value = values.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{where}{name}: expected a number, got {value!r}")
    return float(value)
