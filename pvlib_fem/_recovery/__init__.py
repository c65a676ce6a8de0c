"""Injection test: add effects of known size to a measured record and find them."""
