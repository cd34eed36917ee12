"""An eclipse from first to last contact: no step between two frames is larger than the moon explains."""

import math
from dataclasses import replace
from datetime import datetime, timedelta, timezone
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

import shadowatmo as sa
from shadowatmo import __main__ as command_line
from shadowatmo.ephemeris import contacts
from shadowatmo.errors import ParameterError
from shadowatmo.observing import observed, observed_scene, observer_radians
from shadowatmo.sequence import (
    AUREOLE,
    Steps,
    compare_steps,
    counted,
    explained_share,
    frame_times,
    strip,
    strip_exposures,
    without_moons,
)
from shadowatmo.worlds import WORLDS

MADRAS = (44.633, -121.129, 690.0)
SIZE, FRAMES = (32, 18), 40
EARTH = WORLDS["earth"]
LINE = ("sequence", "--date", "2017-08-21T17:21Z", "--observer", "44.633,-121.129,690")


@pytest.fixture(scope="module")
def found():
    return contacts("2017-08-21T17:00Z", observer_radians(MADRAS))


@pytest.fixture(scope="module")
def camera(found):
    """Away from the sun by 130 degrees, where the shadow comes from: what is there is reached first."""
    return observed(EARTH, found.greatest, MADRAS).camera(math.radians(250), math.radians(20))


@pytest.fixture(scope="module")
def drawn(ctx, found, camera):
    from shadowatmo.passes.sequence import draw_sequence

    return draw_sequence(ctx, EARTH, frame_times(found, FRAMES), MADRAS, camera, SIZE, "fast")


@pytest.fixture(scope="module")
def explained(drawn, camera):
    return np.array([explained_share(scene, camera, SIZE) for scene in drawn.scenes])


def test_no_step_is_larger_than_the_moon_explains(drawn, explained):
    steps = compare_steps(drawn.share, explained)
    assert len(steps.excess) == FRAMES - 1
    assert steps.excess.max() <= 1.0
    assert np.abs(steps.measured).max() > 0.2  # there is something to explain


def test_by_day_and_as_a_crescent_the_share_is_the_explained_one(drawn, explained):
    """All orders come from about the same air while more than a fifth of the sun shines: 1 percent."""
    bright = explained > 0.2
    assert bright.sum() > FRAMES / 4
    assert drawn.share[bright] == pytest.approx(explained[bright], rel=0.01)
    assert drawn.share[[0, -1]] == pytest.approx(1.0, abs=3e-4)  # far air is reached sooner, or left later
    assert drawn.share.min() < 5e-3


@pytest.mark.parametrize("frame", [0, 8, 20, 30, 39])
def test_a_jump_is_noticed(drawn, explained, frame):
    for factor in (1.2, 1 / 1.2):
        shares = drawn.share.copy()
        shares[frame] *= factor
        assert compare_steps(shares, explained).excess.max() > 1.0


def test_scaling_by_the_visible_fraction_at_the_eye_is_noticed(drawn, explained, camera):
    """The wrong way to do it: the sky of totality would be dark at once."""
    local = np.array([sa.sun_visibility(scene, camera.position)[0] for scene in drawn.scenes])
    assert compare_steps(np.maximum(local, 1e-4), explained).excess.max() > 2.0


def test_a_step_the_wrong_way_is_noticed():
    assert Steps(np.array([0.2]), np.array([-0.2])).excess[0] > 1.0
    assert Steps(np.array([-0.2]), np.array([-0.2])).excess[0] == 0.0


def test_times_reach_from_contact_to_contact(found):
    times = frame_times(found, FRAMES)
    assert times == sorted(times) and len(times) == FRAMES
    assert times[0] < found.first < times[1] and times[-2] < found.last < times[-1]
    assert 5 <= sum(found.second < time < found.third for time in times) <= 20
    for count in (1, 0, 2.5, 10**6):
        with pytest.raises(ParameterError, match="frames"):
            frame_times(found, count)


def test_explained_share_without_and_with_a_moon(found, camera):
    before = observed_scene(EARTH, observed(EARTH, found.first - timedelta(minutes=20), MADRAS))
    assert explained_share(before, camera, SIZE) == 1.0
    scene = observed_scene(EARTH, observed(EARTH, found.first + timedelta(minutes=40), MADRAS))
    share, local = explained_share(scene, camera, SIZE), sa.sun_visibility(scene, camera.position)[0]
    assert 0.3 < local < 0.8 and share == pytest.approx(local, rel=0.05)
    assert without_moons(scene).occluders == () and without_moons(scene).suns == scene.suns


def test_the_aureole_does_not_count(found):
    sky = observed(EARTH, found.greatest, MADRAS)
    rays = sky.camera(vertical_fov=math.radians(10.0)).pixel_rays((101, 101))
    masked = ~counted(rays, sky.sun, sky.position)
    assert masked[50, 50] and not masked[0].any()
    angle = math.tan(AUREOLE) / math.tan(math.radians(5.0))
    assert masked.mean() == pytest.approx(math.pi / 4 * angle**2, rel=0.05)


def test_strip_and_exposures():
    images = [Image.new("RGB", (8, 4), (n, 0, 0)) for n in range(1, 8)]
    sheet = np.asarray(strip(images, columns=3, gap=1))
    assert sheet.shape == (3 * 5 - 1, 3 * 9 - 1, 3)
    assert sheet[0, 0, 0] == 1 and sheet[0, 9, 0] == 2 and sheet[5, 0, 0] == 4 and sheet[10, 0, 0] == 7
    assert sheet[4].max() == 0 and sheet[10, 9].max() == 0
    assert strip(images[:2]).size == (18, 4)
    exposures = strip_exposures([2.0, 2.0, 2.0 * 16.0])
    assert exposures == pytest.approx([2.0, 2.0, 16.0])


@pytest.mark.parametrize("jump, status", [(1.0, 0), (1.3, 1)])
@pytest.mark.usefixtures("ctx")
def test_the_command_writes_a_strip_and_judges_it(jump, status, drawn, tmp_path, capsys, monkeypatch):
    from shadowatmo.passes import sequence

    asked, path = [], tmp_path / "strip.png"

    def draw(ctx, planet, times, observer, camera, size, quality, *, cache):
        asked.append((len(times), observer, size, quality, cache))
        assert camera.vertical_fov == pytest.approx(math.radians(60))
        share = drawn.share.copy()
        share[20] *= jump
        return replace(drawn, share=share)

    monkeypatch.setattr(sequence, "draw_sequence", draw)
    monkeypatch.setattr(sa, "open_context", lambda: SimpleNamespace(release=lambda: None), raising=False)
    line = [*LINE, "--frames", str(FRAMES), "--size", "32x18", "--quality", "fast", "--heading", "250", "-o", str(path)]
    assert command_line.main(line) == status
    assert asked == [(FRAMES, MADRAS, (32, 18), "fast", True)]
    with Image.open(path) as image:
        assert image.size == (10 * 34 - 2, 4 * 20 - 2)
    words = capsys.readouterr().out
    assert "darkest at 17:" in words and "largest unexplained step" in words


@pytest.mark.parametrize(
    "options, words",
    [
        (("--date", "2017-08-25T17:21Z"), "eclipse"),
        (("--frames", "1"), "frames"),
        (("--observer", "91,0,0"), "latitude"),
        (("--pitch", "100"), "pitch"),
        (("--out", "x.npy"), "--out"),
    ],
)
def test_what_cannot_be_is_one_line(options, words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sa, "open_context", lambda: pytest.fail("a context was opened"), raising=False)
    assert command_line.main([*LINE, "-o", "x.png", *options]) == 1
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1


def test_another_zone_finds_the_same_eclipse(found):
    there = datetime(2017, 8, 21, 10, 21, tzinfo=timezone(timedelta(hours=-7)))
    assert abs(contacts(there, observer_radians(MADRAS)).greatest - found.greatest) < timedelta(seconds=0.1)
