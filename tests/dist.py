"""Build what is published, and use it as somebody who has nothing else (make dist)."""

import re
import subprocess
import sys
import tarfile
import tempfile
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
DIST = ROOT / "dist"
APART = (".ci/", ".github/workflows/")  # of no use outside the repository


def run(*words, **how):
    subprocess.run([str(word) for word in words], check=True, **how)


def built():
    """The wheel and the sdist, anew, as an index would take them."""
    for old in DIST.glob("pvlib_fem-*"):
        old.unlink()
    run(sys.executable, "-m", "build", "--outdir", DIST, ROOT)
    (wheel,), (sdist,) = DIST.glob("*.whl"), DIST.glob("*.tar.gz")
    run(sys.executable, "-m", "twine", "check", "--strict", wheel, sdist)
    return wheel, sdist


def check_contents(wheel, sdist):
    """Every file that is kept is in the sdist, and the whole package in the wheel."""
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    kept = {name for name in listed.stdout.splitlines() if not name.startswith(APART)}
    with tarfile.open(sdist) as archive:
        whole = {name.partition("/")[2] for name in archive.getnames()}
    if lacking := sorted(kept - whole):
        sys.exit(f"the sdist lacks {', '.join(lacking)}")
    with zipfile.ZipFile(wheel) as archive:
        package = set(archive.namelist())
    lacking = sorted(name for name in kept - package if name.startswith("pvlib_fem/"))
    if lacking or "pvlib_fem/py.typed" not in package:
        sys.exit(f"the wheel lacks {', '.join(lacking) or 'py.typed'}")


def check_install(wheel):
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
        run(python, "-m", "pip", "install", "--quiet", wheel)
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


if __name__ == "__main__":
    files = built()
    check_contents(*files)
    check_install(files[0])
    print(f"{' and '.join(file.name for file in files)} are ready in {DIST.name}/")
