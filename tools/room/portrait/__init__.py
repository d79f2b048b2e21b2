"""Single things on show, in any light and paint, to learn their names from."""
