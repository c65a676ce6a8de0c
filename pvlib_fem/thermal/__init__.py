"""The one equation: steady models, and the dynamics that answers them."""
