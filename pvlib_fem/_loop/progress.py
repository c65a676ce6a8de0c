"""How far a loop is: told to the log, and to whoever asks."""

import logging
from contextlib import ExitStack, contextmanager

from tqdm import tqdm

LOG = logging.getLogger("pvlib_fem")


def line(disable=None):
    """One line on a terminal, which goes away; nothing elsewhere unless requested."""
    return tqdm(
        desc="looking at the record",
        disable=disable,
        leave=False,
        bar_format="{desc} [{elapsed}]",
    )


@contextmanager
def telling(progress=None):
    """
    A function that takes each stage in a few words.

    Parameters
    ----------
    progress : callable or bool, optional
        Called with the words, too; True shows them on one line, as the command does.
    """
    with ExitStack() as stack:
        if progress is True:
            progress = stack.enter_context(line(disable=False)).set_description_str

        def tell(words):
            LOG.info(words)
            if progress:
                progress(words)

        yield tell


@contextmanager
def counting(whole, done=0, shown=True, words=None):
    """
    A function that takes each finished item, of so many; with a bar.

    ``shown`` is True, False, or None for a bar on a terminal only.
    """
    hidden = None if shown is None else not shown
    with tqdm(total=whole, initial=done, disable=hidden, desc=words) as bar:

        def tell(words):
            LOG.info("%s, %d of %d", words, bar.n, whole)
            bar.set_postfix_str(words, refresh=False)
            bar.update()

        yield tell
