"""
Check a built site: its links lead somewhere, and every public name is there once.

``python docs/check.py docs/_build/html``
"""

import importlib
import inspect
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from sphinx.util.inventory import InventoryFile

import pvlib_fem

MODULES = [
    name for name in pvlib_fem.__all__ if inspect.ismodule(getattr(pvlib_fem, name))
]


class Page(HTMLParser):
    """Where a page leads, what it names, and what it loads."""

    def __init__(self, path):
        super().__init__()
        self.links, self.names, self.bare = [], set(), []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.names |= {attributes.get("id"), attributes.get("name")}
        self.links += [
            attributes[key] for key in ("href", "src") if attributes.get(key)
        ]
        if tag == "img" and "alt" not in attributes:  # an empty one is decoration
            self.bare.append(attributes.get("src"))


def broken(root):
    """Links that lead nowhere, and pictures that say nothing to who cannot see."""
    found = [
        path for path in sorted(root.rglob("*.html")) if "_static" not in path.parts
    ]
    pages = {path.resolve(): Page(path) for path in found}
    for path, page in pages.items():
        here = path.relative_to(root)
        yield from (f"{here}: {picture} has no alt text" for picture in page.bare)
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = path
            if parts.path:
                target = (path.parent / unquote(parts.path)).resolve()
            if not target.exists():
                yield f"{here}: {link} is no file"
                continue
            named = pages[target].names if target in pages else None
            if parts.fragment and named and unquote(parts.fragment) not in named:
                yield f"{here}: {link} is no place of that page"


def public():
    """All names that a user may call, as the documentation spells them."""
    for name in pvlib_fem.__all__:
        if name not in MODULES:
            yield f"pvlib_fem.{name}"
            continue
        module = importlib.import_module(f"pvlib_fem.{name}")
        for inner in module.__all__:
            thing = getattr(module, inner)
            if callable(thing) and not hasattr(pvlib_fem, inner):
                yield f"pvlib_fem.{name}.{inner}"


def undocumented(root):
    """Public names that are not in the inventory, or on more than one page."""
    with (root / "objects.inv").open("rb") as file:
        inventory = InventoryFile.load(file, "", lambda base, path: path)
    places = {}
    for kind, entries in inventory.items():
        if kind.startswith("py:"):
            for name, entry in entries.items():
                places.setdefault(name, set()).add(entry.uri.partition("#")[0])
    for name in public():
        if len(places.get(name, ())) != 1:
            yield f"{name} is documented on {len(places.get(name, ()))} pages"


def main(folder):
    root = Path(folder).resolve()
    found = [*broken(root), *undocumented(root)]
    print("\n".join(found))
    count = len(list(root.rglob("*.html")))
    print(f"{count} pages, {len(list(public()))} public names, {len(found)} faults")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
