"""What can go wrong between a question and its answer."""


class SceneError(Exception):
    """The base of all errors of this package."""


class DisconnectedError(SceneError):
    """No router where the client was told to look."""


class NoAnswerError(SceneError):
    """Nobody answers for the scene, or not in time."""


class BusyError(SceneError):
    """The scene has too much to do, and still had after the last try."""


class RefusedError(SceneError):
    """The scene answered with an error; ``code`` says which, ``hint`` what may help."""

    def __init__(self, code: str, message: str, hint: str = "") -> None:
        super().__init__(f"{code}: {message}" + (f" ({hint})" if hint else ""))
        self.code = code
        self.message = message
        self.hint = hint
