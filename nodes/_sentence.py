"""The sentence encoder: all-MiniLM-L6-v2, int8 weights, in ONNX Runtime."""

from pathlib import Path
from typing import Any

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.joint import unit


class SentenceTower:
    """Loads on construction (about 0.2 s); ``embed`` may be called by several threads."""

    def __init__(self, model: Path, tokenizer: Path, threads: int) -> None:
        from tokenizers import Tokenizer

        self._tokenizer = Tokenizer.from_file(str(tokenizer))
        self._tokenizer.no_padding()
        self._session = session(model, threads)

    def embed(self, text: str) -> Float32:
        """Return the mean of the token vectors (384,), length 1; long texts are cut at 128."""
        ids = np.array([self._tokenizer.encode(text).ids], np.int64)
        inputs = {
            "input_ids": ids,
            "attention_mask": np.ones_like(ids),
            "token_type_ids": np.zeros_like(ids),
        }
        tokens: Float32 = self._session.run(["last_hidden_state"], inputs)[0][0]
        return unit(tokens.mean(axis=0))


def session(model: Path, threads: int) -> Any:
    """Return an ONNX Runtime session on the CPU that uses ``threads`` threads."""
    from onnxruntime import InferenceSession, SessionOptions

    options = SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 3
    return InferenceSession(str(model), options, providers=["CPUExecutionProvider"])
