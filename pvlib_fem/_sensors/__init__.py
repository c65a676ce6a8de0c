"""Compare several module temperature sensors of one plant."""
