"""
Build what is published, and use it as somebody who has nothing else (make dist).

The wheel is tried with the newest dependencies and with the oldest that pyproject.toml
allows, and the sdist is built again in a folder that is no repository.
"""

import re
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
DIST = ROOT / "dist"
OLDEST = ROOT / ".github" / "oldest.txt"
# of no use outside the repository
APART = (
    ".ci/",
    ".github/workflows/",
    ".github/ISSUE_TEMPLATE/",
    ".github/PULL_REQUEST_TEMPLATE.md",
    ".readthedocs.yaml",
)


def run(*words, **how):
    subprocess.run([str(word) for word in words], check=True, **how)


def one(folder, pattern):
    """The only file of a kind in a folder."""
    (found,) = folder.glob(pattern)
    return found


def build(source, out):
    """The wheel and the sdist of a folder; the wheel is built from the sdist."""
    run(sys.executable, "-m", "build", "--outdir", out, source)
    return one(out, "*.whl"), one(out, "*.tar.gz")


def built():
    """The wheel and the sdist, anew, as an index would take them."""
    for old in DIST.glob("pvlib_fem-*"):
        old.unlink()
    wheel, sdist = build(ROOT, DIST)
    run(sys.executable, "-m", "twine", "check", "--strict", wheel, sdist)
    return wheel, sdist


def in_wheel(path):
    with zipfile.ZipFile(path) as archive:
        return set(archive.namelist())


def in_sdist(path):
    with tarfile.open(path) as archive:
        return {name.partition("/")[2] for name in archive.getnames()}


def check_contents(wheel, sdist):
    """Every file that is kept is in the sdist, and the whole package in the wheel."""
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    kept = {name for name in listed.stdout.splitlines() if not name.startswith(APART)}
    if lacking := sorted(kept - in_sdist(sdist)):
        sys.exit(f"the sdist lacks {', '.join(lacking)}")
    package = in_wheel(wheel)
    lacking = sorted(name for name in kept - package if name.startswith("pvlib_fem/"))
    if lacking or "pvlib_fem/py.typed" not in package:
        sys.exit(f"the wheel lacks {', '.join(lacking) or 'py.typed'}")


def check_rebuilt(wheel, sdist):
    """The unpacked sdist, which has no git, builds the same wheel and sdist."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        with tarfile.open(sdist) as archive:
            archive.extractall(folder, filter="data")
        again = build(one(folder, "pvlib_fem-*"), folder / "again")
        for old, new, content in zip((wheel, sdist), again, (in_wheel, in_sdist)):
            if (old.name, content(old)) != (new.name, content(new)):
                other = ", ".join(sorted(content(old) ^ content(new)))
                sys.exit(f"without git, {new.name} differs from {old.name}: {other}")


def check_install(wheel, *constraint):
    """The README's first lines print what it shows, from the wheel alone."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (code, *_), (shown, *_) = (
        re.findall(rf"```{language}\n(.*?)```", readme, re.DOTALL)
        for language in ("python", "text")
    )
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        bin_ = Path(folder) / ("Scripts" if sys.platform == "win32" else "bin")
        python = bin_ / "python"
        run(python, "-m", "pip", "install", "--quiet", wheel, *constraint)
        answer = subprocess.run(
            [str(python), "-X", "utf8", "-c", code],
            cwd=folder,
            check=True,
            capture_output=True,
            encoding="utf-8",
        )
        run(bin_ / "pvlib-fem", "--version", cwd=folder)
    if answer.stdout != shown:
        sys.exit(
            f"the README shows other lines than the wheel prints:\n{answer.stdout}"
        )


def oldest_python():
    """The lowest Python that pyproject.toml allows, as (3, 11)."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    lowest = project["project"]["requires-python"].removeprefix(">=")
    return tuple(map(int, lowest.split(".")))


if __name__ == "__main__":
    files = built()
    check_contents(*files)
    check_rebuilt(*files)
    check_install(files[0])
    if sys.version_info[:2] == oldest_python():
        check_install(files[0], "--constraint", OLDEST)
    else:  # the lower bounds have wheels for the oldest Python only
        print(
            "not tried with the oldest dependencies, which need Python "
            f"{'.'.join(map(str, oldest_python()))}: make dist PYTHON=... VENV=..."
        )
    print(f"{' and '.join(file.name for file in files)} are ready in {DIST.name}/")
