"""An ONNX model: where it runs and what it takes and gives."""

from pathlib import Path
from typing import Any, NamedTuple

from sceneq_core.arrays import Array
from sceneq_nodes._model_error import ModelError

PROVIDERS = {"cpu": "CPUExecutionProvider", "cuda": "CUDAExecutionProvider"}
DEVICES = ("auto", *PROVIDERS)


class Port(NamedTuple):
    """An input or output; sizes that may vary are strings or None, ``kind`` is as tensor(float)."""

    name: str
    shape: tuple[int | str | None, ...]
    kind: str


class OnnxModel:
    """A loaded model."""

    def __init__(self, path: Path, device: str, threads: int) -> None:
        """Load it.

        Raises:
            ModelError: not an ONNX model, or no such device for this ONNX Runtime.
        """
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = threads
        options.inter_op_num_threads = 1
        options.log_severity_level = 3
        providers = _providers(device, onnxruntime.get_available_providers())
        try:
            self._session = onnxruntime.InferenceSession(str(path), options, providers=providers)
        except Exception as error:  # ONNX Runtime has a class of its own for every failure
            raise ModelError(f"{path}: no usable ONNX model: {_first_line(error)}") from error
        self._path = path
        self.inputs = [_port(one) for one in self._session.get_inputs()]
        self.outputs = [_port(one) for one in self._session.get_outputs()]

    def run(self, fed: dict[str, Array], wanted: list[str]) -> list[Any]:
        """Return the outputs ``wanted``; raise ``ValueError`` when the model refuses the input."""
        try:
            return list(self._session.run(wanted, fed))
        except Exception as error:
            shapes = {name: value.shape for name, value in fed.items()}
            raise ValueError(f"{self._path}: fed {shapes}: {_first_line(error)}") from error


def need_onnx_device(params: Any) -> None:
    """Refuse a ``device`` that is none of ``DEVICES``."""
    if params.device not in DEVICES:
        raise ValueError(f"device: expected one of {', '.join(DEVICES)}, got {params.device!r}")


def _providers(device: str, available: list[str]) -> list[str]:
    """Return what to run on, the CPU last: it takes the operators that a GPU does not have."""
    if device == "cuda" and PROVIDERS["cuda"] not in available:
        raise ModelError(
            "device: this ONNX Runtime has no CUDA (pip install onnxruntime-gpu instead of "
            "onnxruntime)"
        )
    wanted = ("cpu",) if device == "cpu" else ("cuda", "cpu")
    return [PROVIDERS[one] for one in wanted if PROVIDERS[one] in available]


def _port(told: Any) -> Port:
    return Port(told.name, tuple(told.shape), told.type)


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
