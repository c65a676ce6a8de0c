"""The catalogue of physical effects, one per file."""
