"""Which keyframes show an instance best, and the images they need."""
