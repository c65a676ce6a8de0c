"""What Python and a shell spell differently, in one message."""

from typing import Self


class Spelled(str):
    """A text as Python has it; ``shell`` is the same for the command line."""

    shell: str

    # the default is what unpickling and copying call, and then set the shell's
    def __new__(cls, python: str, shell: str = "") -> Self:
        text = super().__new__(cls, python)
        text.shell = shell
        return text


def spelled(*parts: str) -> Spelled:
    """A text of parts, of which some are spelled differently."""
    return Spelled("".join(parts), "".join(map(in_shell, parts)))


def refusal(*parts: str) -> ValueError:
    """The error of a text of parts."""
    return ValueError(spelled(*parts))


def in_shell(text: object) -> str:
    """A text, or what an error says, as a person at a shell needs it."""
    said = text.args[0] if isinstance(text, Exception) and text.args else text
    return said.shell if isinstance(said, Spelled) else str(text)


def argument(name: str, value: object) -> Spelled:
    """An argument with its value, which is an option of the command, too."""
    return Spelled(f"{name}={value!r}", f"--{name.replace('_', '-')} {value}")


LEAST_SQUARES = argument("method", "least_squares")
UNCHECKED = Spelled("check_units=False (--no-unit-check)", "--no-unit-check")
FIXED = Spelled("fixed", "--fix")
