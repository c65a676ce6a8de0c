"""
Build what is published, and use it as somebody who has nothing else (make dist).

The wheel is tried with the newest dependencies and with the oldest that pyproject.toml
allows, and the sdist is built again in a folder that is no repository. The conda recipe
is rendered, and followed with the packages of PyPI: conda's own are not here.
"""

import os
import re
import shlex
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import venv
import zipfile
from contextlib import contextmanager
from pathlib import Path

import yaml

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
    ".git",  # .gitattributes, .git_archival.txt: an sdist knows its version
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


def version_of(wheel):
    return wheel.name.split("-")[1]


def check_release(version):
    """A release is what the changelog, the citation and the recipe are of."""
    if re.fullmatch(r"[\d.]+", version) is None:  # between two releases
        return
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    top = re.search(r"^## (.+)$", changes, re.MULTILINE)[1]
    dated = re.fullmatch(rf"{re.escape(version)} \(\d{{4}}-\d\d-\d\d\)", top)
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    if not dated or cited["version"] != version or "date-released" not in cited:
        sys.exit(
            f"the tag says {version}, CHANGELOG.md {top}, and CITATION.cff "
            f"{cited['version']} of {cited.get('date-released', 'no date')}"
        )


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


@contextmanager
def environment():
    """An empty folder with an environment of its own: the folder and its programs."""
    with tempfile.TemporaryDirectory() as folder:
        venv.create(Path(folder) / "env", with_pip=True)
        scripts = "Scripts" if sys.platform == "win32" else "bin"
        yield Path(folder), Path(folder) / "env" / scripts


def check_install(wheel, *constraint):
    """The README's first lines print what it shows, from the wheel alone."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (code, *_), (shown, *_) = (
        re.findall(rf"```{language}\n(.*?)```", readme, re.DOTALL)
        for language in ("python", "text")
    )
    with environment() as (folder, bin_):
        run(bin_ / "python", "-m", "pip", "install", "--quiet", wheel, *constraint)
        printed = said(folder, bin_ / "python", "-X", "utf8", "-c", code)
        version = said(folder, bin_ / "pvlib-fem", "--version")
    if printed != shown:
        sys.exit(f"the README shows other lines than the wheel prints:\n{printed}")
    if version.split()[-1] != version_of(wheel):
        sys.exit(f"{wheel.name} says that it is {version}")


def said(folder, *words):
    how = dict(cwd=folder, check=True, capture_output=True, encoding="utf-8")
    return subprocess.run([str(word) for word in words], **how).stdout


def rendered(version):
    """The recipe of a version as rattler-build has it, or None without it."""
    try:
        from rattler_build import Stage0Recipe, VariantConfig
    except ImportError:
        return None
    os.environ["PVLIB_FEM_VERSION"] = version
    recipe = Stage0Recipe.from_file(ROOT / "conda.recipe" / "recipe.yaml")
    (variant,) = recipe.render(VariantConfig())
    return variant.recipe.to_dict()


def from_pypi(recipe, part):
    """What a part of the recipe needs, as pip has it; Python is there."""
    return [row for row in recipe["requirements"][part] if row.split()[0] != "python"]


def check_recipe(sdist, version):
    """The conda recipe's steps and tests, with packages of the same names from PyPI."""
    recipe = rendered(version)
    if recipe is None:
        print("the conda recipe is not tried: py-rattler-build is not installed")
        return
    (source,) = recipe["source"]
    if (ROOT / "conda.recipe" / source["path"]).resolve() != sdist.resolve():
        sys.exit(f"the conda recipe builds from {source['path']}, not {sdist.name}")
    with environment() as (folder, bin_), tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
        path = {**os.environ, "PATH": f"{bin_}{os.pathsep}{os.environ['PATH']}"}
        pip = bin_ / "python", "-m", "pip"
        run(*pip, "install", "--quiet", *from_pypi(recipe, "host"))
        step = shlex.split(recipe["build"]["script"])
        run(*step, "-qqq", cwd=one(folder, "pvlib_fem-*"), env=path)
        run(*pip, "install", "--quiet", *from_pypi(recipe, "run"))
        run(*pip, "check")
        for test in recipe["tests"]:
            for line in test.get("script", ()):
                run(*shlex.split(line), cwd=folder, env=path)


def oldest_python():
    """The lowest Python that pyproject.toml allows, as (3, 11)."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    lowest = project["project"]["requires-python"].removeprefix(">=")
    return tuple(map(int, lowest.split(".")))


if __name__ == "__main__":
    files = built()
    check_release(version_of(files[0]))
    check_contents(*files)
    check_rebuilt(*files)
    check_recipe(files[1], version_of(files[0]))
    check_install(files[0])
    if sys.version_info[:2] == oldest_python():
        check_install(files[0], "--constraint", OLDEST)
    else:  # the lower bounds have wheels for the oldest Python only
        print(
            "not tried with the oldest dependencies, which need Python "
            f"{'.'.join(map(str, oldest_python()))}: make dist PYTHON=... VENV=..."
        )
    print(f"{' and '.join(file.name for file in files)} are ready in {DIST.name}/")
