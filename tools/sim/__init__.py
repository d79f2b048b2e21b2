"""A simulated robot in a furnished room that people can change while it looks around."""
