"""Which single effects there are, and how probable each candidate is."""
