"""A word encoder in whose space nothing compares with the first one's."""

from support.furnished import WordEncoder


class OtherWords(WordEncoder):
    """The same words, in fewer dimensions."""

    model_id = "other-words"
    dim = 192
