"""A run of the graph in one MCAP file, and bags of others: written, and read as a source."""
