"""Furnished rooms with exact truth.

``layout`` furnishes a room with ``models`` and ``textures``, ``light`` renders it, ``camera``
carries an RGB-D sensor through it, ``truth`` says what is there and asks about it.

World frame of a room: metres, z up, floor at z = 0, x in [0, width], y in [0, depth].
A model's own frame: metres, z up, origin at the bottom centre, its front looks towards -y.
"""
