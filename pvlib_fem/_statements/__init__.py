"""What a loop found, in sentences: device, direction, size, dates and action."""
