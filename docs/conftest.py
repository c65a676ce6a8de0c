"""Examples in the pages are run; what builds the site is not theirs."""

collect_ignore_glob = ["*.py", "_ext/*", "_build/*", "gallery/*", "generated/*"]
