"""The page that a study makes."""


def publish(text, out=None):
    """Write the Markdown of a page to a path, or print it where there is none."""
    if out is None:
        print(text)
    else:
        out.write_text(text, encoding="utf-8", newline="\n")
