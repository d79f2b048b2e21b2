"""How Scene-Q computes: pure algorithms on arrays; no bus, no files, no clock."""
