"""What flows between Scene-Q processes: message types, their codec and the table of keys."""
