"""Which calibration an encoder gets: one that is given, the one that comes with the program, none.

The shipped ones are in ``nodes/calibrations``, named by the id of the encoder they were fitted for.
An id changes whenever vectors do, so that none is ever used for other vectors.
"""

from pathlib import Path

from sceneq_core.encoding.encoder import Encoder
from sceneq_nodes._calibration import NO_CALIBRATION, Calibration, read_calibration

SHIPPED = Path(__file__).parent / "calibrations"


def chosen_calibration(setting: str, encoder: Encoder) -> Calibration | None:
    """Return the calibration for ``encoder`` that a parameter names.

    ``setting``: "" = the shipped one, if there is one for this encoder; "none" = none; else a
    path.

    Raises:
        ValueError: a file that cannot be used, or one that was made for another encoder.
    """
    if setting == NO_CALIBRATION:
        return None
    if not setting:
        return shipped_calibration(encoder.model_id)
    calibration = read_calibration(Path(setting))
    calibration.of_encoder(encoder)
    return calibration


def former_calibration(setting: str, encoder: Encoder) -> Calibration | None:
    """Return the calibration for an encoder that is about to be replaced; raises as above.

    A file that is given may be for the new encoder: then the shipped one has to do.
    """
    if setting in ("", NO_CALIBRATION):
        return chosen_calibration(setting, encoder)
    given = read_calibration(Path(setting))
    return given if given.encoder == encoder.model_id else shipped_calibration(encoder.model_id)


def shipped_calibration(model_id: str) -> Calibration | None:
    """Return the calibration that comes with the program, ``None`` when there is none."""
    path = SHIPPED / f"{model_id}.json"
    return read_calibration(path) if path.is_file() else None
