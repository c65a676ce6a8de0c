"""Coefficients from a measured record."""
