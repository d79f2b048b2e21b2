"""What WordNet says a word means: an independent source of other words for household things.

G. Miller, "WordNet: a lexical database for English", CACM 1995, doi 10.1145/219717.219748; the
files are those of Debian's package ``wordnet-base`` (format: wndb(5WN)).
"""

from pathlib import Path

DEFAULT_FOLDER = Path("/usr/share/wordnet")
PACKAGE_HINT = "apt-get install wordnet-base"

THINGS = {"06", "13", "20"}
"""Files of the lexicographers with artefacts, food and plants."""


class WordNet:
    """The nouns of a dictionary folder."""

    def __init__(self, folder: Path = DEFAULT_FOLDER) -> None:
        """Read the index; raise ``OSError`` when it is not there."""
        self._data = (folder / "data.noun").read_bytes()
        lines = (folder / "index.noun").read_text("utf-8").splitlines()
        entries = (line.split() for line in lines if not line.startswith(" "))
        self._offsets = {words[0]: words[-int(words[2]) :] for words in entries}

    def gloss(self, noun: str) -> str | None:
        """Return the definition of the commonest thing called so, ``None`` when there is none."""
        for offset in self._offsets.get(noun.lower().replace(" ", "_"), ()):
            start = int(offset)
            record = self._data[start : self._data.index(b"\n", start)].decode()
            if record.split()[1] in THINGS:
                return record.split("| ", 1)[1].split('; "')[0].strip()
        return None
