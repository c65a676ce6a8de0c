"""``python -m pvlib_fem`` is the command ``pvlib-fem``."""

from pvlib_fem._cli import main

if __name__ == "__main__":
    main(prog_name="pvlib-fem")
