"""Where and in which numbers a torch model runs."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sceneq_core.arrays import Float32

if TYPE_CHECKING:
    import torch

DEVICE = re.compile(r"auto|cpu|cuda(:\d+)?")
DTYPES = ("auto", "float32", "float16", "bfloat16")


def need_device(params: Any) -> None:
    """Refuse a ``device`` that is not auto, cpu, cuda or cuda:N."""
    if not DEVICE.fullmatch(params.device):
        raise ValueError(f"device: expected auto, cpu, cuda or cuda:N, got {params.device!r}")


def need_dtype(params: Any) -> None:
    """Refuse a ``dtype`` that is none of ``DTYPES``."""
    if params.dtype not in DTYPES:
        raise ValueError(f"dtype: expected one of {', '.join(DTYPES)}, got {params.dtype!r}")


def chosen_device(device: str) -> "torch.device":
    """Return the device; ``auto`` is the first GPU, or the CPU where there is none.

    Raises:
        ValueError: a GPU that this torch does not see.
    """
    import torch

    if device == "auto":
        return torch.device("cuda" if torch.cuda.is_available() else "cpu")
    chosen = torch.device(device)
    if chosen.type == "cuda" and (chosen.index or 0) >= torch.cuda.device_count():
        seen = torch.cuda.device_count()
        raise ValueError(
            f"device: no {device} for torch {torch.__version__}, which sees {seen} GPUs"
        )
    return chosen


def chosen_dtype(dtype: str, device: "torch.device") -> "torch.dtype":
    """Return the dtype; ``auto`` is float16 on a GPU and float32 on a CPU."""
    import torch

    if dtype == "auto":
        return torch.float16 if device.type == "cuda" else torch.float32
    chosen: torch.dtype = getattr(torch, dtype)
    return chosen


def quiet_transformers() -> Any:
    """Return transformers without bars and without words about weights that are not used."""
    import transformers

    logging: Any = transformers.logging
    logging.set_verbosity_error()
    logging.disable_progress_bar()
    return transformers


def pretrained(name: str, folder: Path, device: str, dtype: str, **arguments: Any) -> Any:
    """Return the class ``name`` of transformers with the weights in ``folder``, ready to be asked.

    Raises:
        ValueError: weights that the class needs are not there; it would make them up.
    """
    chosen = chosen_device(device)
    given = {"dtype": chosen_dtype(dtype, chosen), "output_loading_info": True, **arguments}
    model, told = getattr(quiet_transformers(), name).from_pretrained(folder, **given)
    if missing := sorted(told["missing_keys"]):
        some = ", ".join(missing[:3])
        raise ValueError(f"{folder}: {len(missing)} weights of {name} are missing, such as {some}")
    return model.to(chosen).eval()


def to_numpy(tensor: "torch.Tensor") -> Float32:
    """Return a tensor of any device and float type as float32."""
    return np.asarray(tensor.detach().float().cpu().numpy(), np.float32)
