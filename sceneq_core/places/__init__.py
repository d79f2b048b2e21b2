"""Places: what a map remembers of itself so that a camera can find out where in it it is."""
