"""What is used, what is tried, and what is left out."""
