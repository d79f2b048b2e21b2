"""Who may join the bus, and what each may do there."""
