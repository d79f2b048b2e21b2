"""Names that people give to things: how they stick, who inherits them, how they are taken back."""
