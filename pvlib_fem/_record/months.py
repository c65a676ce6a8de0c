"""Names of months and halves of a day of several languages, in English."""

import re
import unicodedata
from typing import Any

MONTHS = ("January", "February", "March", "April", "May", "June", "July", "August")
MONTHS += ("September", "October", "November", "December")
#: how the name of each month begins in German, French, Spanish, Italian, Portuguese
#: and Dutch, without accents
BEGIN = (
    "jan ene gen",
    "feb fev fevr",
    "mar mrz maerz maart mrt",
    "apr abr avr",
    "may mai mag mei maio mayo",
    "jun juin giu",
    "jul juil lug",
    "aug ago aout",
    "sep set sept",
    "oct okt ott out",
    "nov",
    "dec dez dic",
)
NUMBER = {word: n for n, names in enumerate(BEGIN) for word in names.split()}
WORD = re.compile(r"[^\W\d_]{3,}\.?")
HALF = re.compile(r"\b([ap])\.?\s?m\b\.?", re.IGNORECASE)


def in_english(text: str, whole: bool) -> str:
    """
    A time with the month's name and the half of the day as English has them.

    Parameters
    ----------
    text : str
        In English, German, French, Spanish, Italian, Portuguese or Dutch.
    whole : bool
        Whether the result has the month's whole name, as of the format ``%B``, or three
        letters of it.

    Returns
    -------
    str
        Other words are unchanged.
    """

    def month(match: Any) -> Any:
        if match[0] in MONTHS:  # which is another format than Jan
            return match[0]
        word = plain_word(match[0])
        # the longest beginning that is known: juil is July, jui nothing
        known = (NUMBER.get(word[:n]) for n in (5, 4, 3))
        number = next((n for n in known if n is not None), None)
        if number is None:
            return match[0]
        return MONTHS[number] if whole else MONTHS[number][:3]

    return HALF.sub(lambda half: half[1].upper() + "M", WORD.sub(month, text))


def plain_word(word: str) -> str:
    """A word in small letters without accents and its full stop."""
    apart = unicodedata.normalize("NFKD", word.strip(".").lower())
    return "".join(letter for letter in apart if not unicodedata.combining(letter))
