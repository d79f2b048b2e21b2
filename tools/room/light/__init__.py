"""Light and pictures: ray casting on a CPU under light that was measured beforehand."""
