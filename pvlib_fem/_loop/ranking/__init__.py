"""Effects that were not found, with their minimum detectable gain."""
