"""Faults on purpose: each scenario harms a running graph and looks at what was lost."""
