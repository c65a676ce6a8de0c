"""Several sensors at the modules of one plant: what is common, what is one's own."""
