"""The camera: how it is carried through the room, and what its sensors make of what it sees."""
