"""Checks of the machine: what is there, does it suffice, and the one command that mends it.

Every check is a function of its environment, with the real one as default, and returns one
``Finding``; ``examination.CHECKS`` lists them in the order in which they are told.
"""
