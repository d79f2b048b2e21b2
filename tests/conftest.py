"""How hypothesis looks for examples: the same way every time, however slow the machine is.

``HYPOTHESIS_PROFILE=default pytest`` looks for others each time.
"""

import os

from hypothesis import settings

settings.register_profile("steady", deadline=None, derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "steady"))
