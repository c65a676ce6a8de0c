"""The record as the loop uses it, and the effects that it tries."""
