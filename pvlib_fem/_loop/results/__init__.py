"""Findings, patterns, and the result."""
