"""What is shipped: packages, shader files, images with the documented content, text without machine paths."""

import fnmatch
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "shadowatmo" / "data"
SETUPTOOLS = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]
METERS_PER_LEVEL = 6400 / 255  # shadowatmo/data/README.md
WATER_RGB = (8, 22, 48)


# --- packages and their files


def packages_on_disk(root):
    """Dotted names of all folders with an __init__.py; passes/ and shaders/ belong to shadowatmo."""
    found = set()
    for top, prefix in (("shadowatmo", ()), ("passes", ("shadowatmo",)), ("shaders", ("shadowatmo",))):
        for init in (root / top).rglob("__init__.py"):
            found.add(".".join((*prefix, *init.parent.relative_to(root).parts)))
    return found


def folder_of(package, package_dir):
    """Folder that setuptools takes a package from: the longest mapped prefix, then the rest of the name."""
    parts = package.split(".")
    for n in range(len(parts), 0, -1):
        mapped = package_dir.get(".".join(parts[:n]))
        if mapped is not None:
            return "/".join((mapped, *parts[n:]))
    return "/".join(parts)


def uncovered(names, patterns):
    """File names that are neither Python sources nor matched by a package-data pattern."""
    return [n for n in names if not n.endswith(".py") and not any(fnmatch.fnmatch(n, p) for p in patterns)]


def test_every_package_is_listed():
    assert set(SETUPTOOLS["packages"]) == packages_on_disk(ROOT)


def test_an_unlisted_package_is_noticed(tmp_path):
    for folder in ("shadowatmo", "passes/gl/new"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "__init__.py").touch()
    assert packages_on_disk(tmp_path) == {"shadowatmo", "shadowatmo.passes.gl.new"}


@pytest.mark.parametrize("package", SETUPTOOLS["packages"])
def test_package_folder(package):
    assert (ROOT / folder_of(package, SETUPTOOLS["package-dir"]) / "__init__.py").is_file()


def test_package_folder_of_an_unmapped_name():
    assert folder_of("shadowatmo.passes.x", {"shadowatmo": "shadowatmo"}) == "shadowatmo/passes/x"
    assert folder_of("shadowatmo.passes.x", SETUPTOOLS["package-dir"]) == "passes/x"


@pytest.mark.parametrize("package", SETUPTOOLS["packages"])
def test_package_data_covers_every_file(package):
    folder = ROOT / folder_of(package, SETUPTOOLS["package-dir"])
    names = [p.name for p in folder.iterdir() if p.is_file()]
    assert uncovered(names, SETUPTOOLS["package-data"].get(package, [])) == []


def test_an_uncovered_file_is_noticed():
    assert uncovered(["a.frag", "b.tesc", "c.py"], ["*.frag"]) == ["b.tesc"]


def test_shaders_are_flat():
    """setuptools takes a folder inside a data package for a package that was forgotten."""
    assert [p.name for p in (ROOT / "shaders").iterdir() if p.is_dir() and p.name != "__pycache__"] == []


# --- images


@pytest.fixture(scope="module")
def color():
    with Image.open(DATA / "earth_color.jpg") as image:
        assert image.mode == "RGB"
        return np.asarray(image).astype(float)


@pytest.fixture(scope="module")
def level():
    with Image.open(DATA / "earth_height.png") as image:
        assert image.mode == "L"
        return np.asarray(image).astype(float)


def cell(picture, latitude, longitude):
    """Pixel that holds a place (degrees): the left edge is 180 W, the top edge 90 N."""
    rows, columns = picture.shape[:2]
    row = min(int((90 - latitude) / 180 * rows), rows - 1)
    return picture[row, int((longitude + 180) / 360 * columns) % columns]


def test_sizes(color, level):
    assert color.shape == (2048, 4096, 3)
    assert level.shape == (1024, 2048)


def test_data_is_small():
    assert sum(p.stat().st_size for p in DATA.iterdir() if p.is_file() and p.suffix != ".py") < 1.5e6


# (latitude, longitude, surveyed height [m]). Plains, ice and lakes: a 20 km cell is as high as the place
# itself to two levels of 25 m, one for truncation to a level, one for slopes.
FLAT_PLACES = {
    "Dome A": (-80.37, 77.35, 4093),
    "Vostok": (-78.46, 106.84, 3488),
    "South Pole": (-90.0, 0.0, 2835),
    "Greenland summit": (72.58, -38.46, 3216),
    "Salar de Uyuni": (-20.2, -67.5, 3656),
    "Lake Titicaca": (-15.8, -69.4, 3812),
    "Siling Co, Tibet": (31.8, 89.0, 4530),
    "Lake Victoria": (-1.0, 33.0, 1134),
    "Great Salt Lake": (41.0, -112.6, 1280),
    "Lake Superior": (47.7, -88.0, 183),
    "Kansas": (38.5, -98.0, 510),
    "Denver": (39.74, -104.99, 1609),
}
SEAS = {
    "central Pacific": (0, -160),
    "Pacific at the wrap": (-30, 180),
    "North Atlantic": (30, -40),
    "Indian Ocean": (-20, 80),
    "North Pole": (90, 0),
    "Southern Ocean": (-60, 0),
    "North Sea": (56, 3),
    "Mediterranean": (35, 18),
    "Hudson Bay": (60, -85),
    "Caspian Sea": (42, 50.5),
}
LOWLANDS = {
    "Manaus": (-3.1, -60),
    "Amsterdam": (52.37, 4.9),
    "Ross ice shelf": (-82, -175),
    "Dead Sea": (31.5, 35.5),
}


def worst_height_error(level):
    return max(abs(cell(level, a, b) * METERS_PER_LEVEL - height) for a, b, height in FLAT_PLACES.values())


def test_heights_of_known_places(level):
    assert worst_height_error(level) <= 2 * METERS_PER_LEVEL


@pytest.mark.parametrize("wrong", [np.fliplr, np.flipud, lambda x: np.roll(x, 1024, axis=1)])
def test_heights_reject_a_wrong_orientation(level, wrong):
    assert worst_height_error(wrong(level)) > 1000


def test_mountains(level):
    assert cell(level, 27.988, 86.925) * METERS_PER_LEVEL > 5000  # Everest; averaging cuts its summit
    assert 600 < cell(level, 44.633, -121.129) * METERS_PER_LEVEL < 850  # Madras, Oregon, 690 m, among hills
    assert level.max() * METERS_PER_LEVEL < 6400


@pytest.mark.parametrize("place", SEAS.values(), ids=SEAS)
def test_seas_are_water(color, level, place):
    assert cell(level, *place) == 0
    assert np.abs(cell(color, *place) - WATER_RGB).max() <= 3  # JPEG


@pytest.mark.parametrize("place", LOWLANDS.values(), ids=LOWLANDS)
def test_lowlands_are_land(level, place):
    assert 1 <= cell(level, *place) <= 3


def test_sea_fraction(level):
    """The oceans cover 70.8 % of the sphere; 20 km cells and small lakes are good for one percent."""
    weight = np.sin((np.arange(1024) + 0.5) * np.pi / 1024)
    assert np.average((level == 0).mean(axis=1), weights=weight) == pytest.approx(0.708, abs=0.01)


def test_colors_of_known_places(color):
    red, green, blue = cell(color, 23, 10)  # Sahara
    assert red > green > blue > 50
    red, green, blue = cell(color, -5, -63)  # Amazon forest
    assert green > red and green > blue and green < 100
    assert cell(color, 72.58, -38.46).min() > 220  # Greenland's ice
    red, green, blue = cell(color, -24, 125)  # Western Australia
    assert red > 1.3 * green > blue


@pytest.mark.parametrize("name", ["color", "level"])
def test_no_seam(name, request):
    """The step across the wrap is like the steps beside it; far apart it is 29 times that or more."""
    picture = request.getfixturevalue(name)

    def step(a, b):
        return np.abs(picture[:, a] - picture[:, b]).mean()

    beside = max(step(k, k - 1) for k in (1, 2, 3, -1, -2, -3))
    assert step(0, -1) < 2 * beside
    assert step(0, picture.shape[1] // 4) > 10 * beside


# --- text

TEXT_FOLDERS = ("shadowatmo", "passes", "shaders", "tests", "tools", "docs", "examples", "bench", ".ci")
TEXT_SUFFIXES = {".py", ".md", ".glsl", ".vert", ".frag", ".geom", ".toml", ".json", ".sh", ".yml", ".txt"}
TEXT_NAMES = {"Makefile", "LICENSE", "run", ".gitignore", "py.typed"}
# Folders that exist on one machine only, and a working folder outside the repository. Spelled in pieces, so
# that this file does not match itself.
MACHINE_PATH = re.compile(
    r"(?<![\w.\-}$])/(?:" + "|".join(("work", "farm", "tmp", "root", "home", "Users")) + r")/"
    r"|[A-Z]:\\" + "Users" + r"|\.\./" + "shared"
)


def text_files():
    paths = [*ROOT.iterdir(), *(path for folder in TEXT_FOLDERS for path in (ROOT / folder).rglob("*"))]
    return [p for p in paths if p.is_file() and (p.suffix in TEXT_SUFFIXES or p.name in TEXT_NAMES)]


def test_no_machine_paths():
    files = text_files()
    assert {"pyproject.toml", "Makefile", "setup.sh", "run", "cases_public.json"} <= {p.name for p in files}
    hits = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}"
        for path in files
        for number, line in enumerate(path.read_text("utf-8").splitlines(), 1)
        if MACHINE_PATH.search(line)
    ]
    assert hits == []


@pytest.mark.parametrize("folder", ["work", "home", "root", "tmp"])
def test_a_machine_path_is_noticed(folder):
    assert MACHINE_PATH.search(f'open("/{folder}/x.json")')
    assert MACHINE_PATH.search(f"/{folder}/x")
    assert not MACHINE_PATH.search(f"https://example.org/{folder}/x")
    assert not MACHINE_PATH.search(f"docs/{folder}/x")
    assert not MACHINE_PATH.search("#!/usr/bin/env bash")
    assert MACHINE_PATH.search("../" + "shared/notes.md")
