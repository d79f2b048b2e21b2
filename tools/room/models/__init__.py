"""Where models of household things come from: Sweet Home 3D's libraries, or simple shapes."""
