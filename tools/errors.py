"""The one exception a command raises when its user has to do something."""


class UserError(Exception):
    """Shown as ``sceneq: message`` on one line of stderr; ``exit_code`` ends the process."""

    def __init__(self, message: str, exit_code: int = 1) -> None:
        super().__init__(message)
        self.exit_code = exit_code
