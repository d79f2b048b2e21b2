"""How fast Scene-Q is here, each time beside something that everybody has.

A bench is a function ``Options -> Iterator[Measurement]`` in a module of its own, listed in
``registry.BENCHES``. What it measures stands beside a reference measured in the same run (a copy of
the same bytes, a bare get, a fixed piece of numpy work), because milliseconds of two machines, or
of one machine on two days, do not compare, and their ratios do.
"""
