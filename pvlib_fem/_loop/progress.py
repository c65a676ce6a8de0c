"""Progress of a loop: in the log, and to the caller."""

import logging
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from tqdm import tqdm

LOG = logging.getLogger("pvlib_fem")


def progress_line(disable: bool | None = None) -> tqdm:
    """
    One line on a terminal, which goes away; nothing elsewhere unless requested.

    Parameters
    ----------
    disable : bool or None, default None
        None for a line on a terminal only; False for one everywhere.

    Returns
    -------
    tqdm
        Context manager; ``set_description_str`` changes the words.
    """
    return tqdm(
        desc="looking at the record",
        disable=disable,
        leave=False,
        bar_format="{desc} [{elapsed}]",
    )


@contextmanager
def stage_reporter(
    progress: Callable[[str], object] | bool | None,
) -> Iterator[Callable[[str], None]]:
    """
    A function that takes each stage in a few words.

    Parameters
    ----------
    progress : callable, bool or None
        Called with the words, too; True shows them on one line, as the command does.

    Yields
    ------
    callable
        Takes the words.
    """
    with ExitStack() as stack:
        show = None if progress is True else progress or None
        if progress is True:
            show = stack.enter_context(progress_line(disable=False)).set_description_str

        def report(words: str) -> None:
            LOG.info(words)
            if show:
                show(words)

        yield report


@contextmanager
def item_counter(
    whole: int, done: int, shown: bool | None, words: str
) -> Iterator[Callable[[str], None]]:
    """
    A function that takes each finished item, of so many; with a bar.

    Parameters
    ----------
    whole, done : int
        Number of items in all, and of those that are finished already.
    shown : bool or None
        None for a bar on a terminal only.
    words : str
        In front of the bar.

    Yields
    ------
    callable
        Takes words on the item.
    """
    hidden = None if shown is None else not shown
    with tqdm(total=whole, initial=done, disable=hidden, desc=words) as bar:

        def report(words: str) -> None:
            LOG.info("%s, %d of %d", words, bar.n, whole)
            bar.set_postfix_str(words, refresh=False)
            bar.update()

        yield report
