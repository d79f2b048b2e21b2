"""A model that cannot be used, whatever it is fed."""


class ModelError(RuntimeError):
    """The text names the file and what was expected of it.

    No ``ValueError``, because segmenters raise those for single frames, which are then skipped.
    """
