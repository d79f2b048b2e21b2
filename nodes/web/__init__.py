"""The map by HTTP: pages of the gateway node."""
