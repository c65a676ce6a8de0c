"""The heat balance: steady models, and the dynamics that solve it."""
