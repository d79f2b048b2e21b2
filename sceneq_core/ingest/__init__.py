"""From raw sensor images to posed, registered keyframes."""
