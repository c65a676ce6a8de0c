"""A measured record: its columns, its checks, its files, its steps."""
