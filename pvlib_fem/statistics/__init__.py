"""Least squares, errors by clusters, tables of what is left."""
