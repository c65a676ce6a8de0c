"""The record without the faults of its instruments that a loop found."""
