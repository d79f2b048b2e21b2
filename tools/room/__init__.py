"""Furnished rooms with exact truth: models, composition, light, camera, sensor, questions.

World frame of a room: metres, z up, floor at z = 0, the room spans x in [0, width], y in [0, depth].
A model's own frame: metres, z up, origin at the bottom centre, its front looks towards -y.
"""
