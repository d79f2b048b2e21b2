"""The error every reader of bytes from the bus has to expect."""


class DecodeError(ValueError):
    """The bytes are not a valid message; the text names schema, field and what was found."""
