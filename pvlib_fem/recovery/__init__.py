"""What would be found: effects of known size put into a measured record."""
