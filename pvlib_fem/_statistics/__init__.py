"""Least squares, cluster-robust errors, and random effects of the residual."""
