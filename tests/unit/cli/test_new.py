"""`companion new` and `companion draw`: a file from answers, and the picture of a boat."""

import itertools
import math
import re
import shlex
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

from companion.cli.drawing import characters, outlines, svg
from companion.cli.main import main
from companion.cli.new_file import BOARDS, LAYOUTS
from companion.config.vessel import bundled, find, load

_SHAPE = ["--name", "cat", "--form", "catamaran", "--length", "1.2", "--beam", "0.9"]
CATAMARAN = [*_SHAPE, "--mass", "30", "--hull-beam", "0.2", "--motor", "T200", "--voltage", "16"]


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("board", BOARDS)
def test_every_layout_on_every_board_becomes_a_boat(tmp_path: Path, layout: str, board: str) -> None:
    file = tmp_path / "boat.toml"
    options = [*CATAMARAN, "--layout", layout, "--board", board, *(["--motor", "80"] if layout == "jet" else [])]
    assert main(["new", str(file), "--yes", *options]) == 0
    boat = load(file)
    assert boat.hull.mass_kg == 30.0 and boat.sitl is not None
    assert (boat.limits.sway_n > 0.0) == (layout in ("twin-bow", "vectored", "azimuth-bow", "two-azimuths"))
    assert "# " in file.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("file", "name"), [("my_boat.toml", "my_boat"), ("4 My Boat-2.toml", "my_boat"), ("7.toml", "boat")]
)
def test_the_short_name_is_that_of_the_file(tmp_path: Path, file: str, name: str) -> None:
    assert main(["new", str(tmp_path / file), "--yes", *CATAMARAN[2:]]) == 0
    assert load(tmp_path / file).name == name


def test_what_to_type_next_is_what_a_shell_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "my böat's 2.toml"
    assert main(["new", str(file), "--yes", *CATAMARAN]) == 0
    said = capsys.readouterr().out
    (check, run) = (shlex.split(line) for line in re.findall(r": companion (.*)", said))
    assert check == ["check", str(file)] and run == ["run", str(file), "--sitl"]


def test_help_has_the_choices_in_running_text(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    with pytest.raises(SystemExit):
        main(["new", "--help"])
    assert "Form of the hull: monohull (one hull: launch, canoe, kayak, model ship); catamaran (two hulls);" in (
        " ".join(capsys.readouterr().out.split())
    )


def test_a_missing_answer_and_a_wrong_one_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(tmp_path / "boat.toml")
    assert main(["new", file, "--yes", "--name", "cat", "--form", "barge", "--length", "3"]) == 2
    assert "missing: --beam, --mass, --motor; give them" in capsys.readouterr().err
    assert main(["new", file, "--yes", *CATAMARAN[:-4], "--motor", "T220"]) == 2
    assert "did you mean 't200'" in capsys.readouterr().err
    assert not Path(file).exists()


def test_a_folder_that_is_not_there_is_said_before_the_questions(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", str(tmp_path / "boats" / "cat.toml"), "--yes", *CATAMARAN]) == 2
    shown = capsys.readouterr()
    assert "boats: no such folder" in shown.err and shown.out == ""


def test_a_fault_of_the_boat_names_the_option_that_it_comes_from(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It named a line of a file that was never written."""
    file = tmp_path / "boat.toml"
    for options, said in (
        (["--mass", "30000"], "new: --mass: 30000 kg on 1.2 m of length float"),
        (["--hull-beam", "0.8"], "new: --hull-beam: two hulls of 0.8 m are wider than beam_m, 0.9"),
        (["--lat", "91"], "new: --lat: should be less than or equal to 89"),
        (["--motor", "0"], "'0': a number above 0"),
        (["--motor", "55 lb"], "it is 'trolling 55 lb'"),
        (["--form", "kayak"], "new: Form of the hull: 'kayak': one of monohull"),
    ):
        assert main(["new", str(file), "--yes", *CATAMARAN, *options]) == 2
        error = capsys.readouterr().err
        assert said in error and "boat.toml" not in error, error


def test_lengths_masses_and_speeds_may_have_other_units(tmp_path: Path) -> None:
    file = tmp_path / "boat.toml"
    other = ["--length", "120 cm", "--mass", "66.14lb", "--hull-beam", "200mm", "--top-speed", "5.4 km/h"]
    assert main(["new", str(file), "--yes", *CATAMARAN, *other]) == 0
    boat = load(file)
    found = (boat.length_m, boat.hull.mass_kg, boat.hull.hull_beam_m, boat.hull.top_speed_mps)
    assert found == pytest.approx((1.2, 30.0, 0.2, 1.5), rel=1e-3)


def test_a_file_that_exists_is_never_overwritten(tmp_path: Path) -> None:
    file = tmp_path / "boat.toml"
    file.write_text("mine")
    assert main(["new", str(file), "--yes", *CATAMARAN]) == 2 and file.read_text() == "mine"


def test_a_largest_thrust_does_instead_of_a_motor(tmp_path: Path) -> None:
    for number, text in enumerate(("80", "80 N", "80,0N")):
        file = tmp_path / f"boat{number}.toml"
        assert main(["new", str(file), "--yes", *CATAMARAN[:-4], "--motor", text]) == 0
        assert load(file).thrusters[0].max_n == 80.0


def test_a_thrust_in_another_unit_is_refused_where_it_is_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", str(tmp_path / "boat.toml"), "--yes", *CATAMARAN[:-4], "--motor", "8 kg"]) == 2
    assert "'8 kg': no motor" in capsys.readouterr().err


def test_who_is_asked_answers_again_where_the_boat_does_not_float(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It ended, and all answers were gone; the draft that it named did not float either."""
    said = ["", "", "monohull", "4 m", "1.5", "180", "0.2", "", "", "100 N", "", "", "two", "0", "-3"]
    again = ["", "", "", "", "", "", "0.19", "", "", "", "", "", "", "", "", "y"]
    answers = iter([*said, *again])
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("builtins.input", lambda *_: next(answers))
    file = tmp_path / "launch.toml"
    assert main(["new", str(file)]) == 0 and next(answers, None) is None
    shown = capsys.readouterr().out
    assert "180 kg do not float so: with this length and beam the draft is from" in shown and "to 0.19 m" in shown
    boat = load(file)
    assert boat.name == "launch" and boat.home.lat_deg == 0.0 and boat.thrusters[0].max_n == 100.0
    assert boat.hull.draft_m == 0.19 and boat.sensors[0].antennas == 2


@pytest.mark.parametrize("name", bundled())
def test_every_bundled_boat_can_be_drawn(name: str) -> None:
    boat = load(find(name))
    picture = ElementTree.fromstring(svg(boat))
    texts = " ".join(text for text in picture.itertext())
    assert all(thruster.name in texts for thruster in boat.thrusters)
    assert all(sensor.name in texts for sensor in boat.sensors)
    listed = characters(boat)
    assert all(re.search(rf"[↑↗→↘↓↙←↖]  {thruster.name}: ", listed) for thruster in boat.thrusters)


def test_sensors_at_one_place_have_their_labels_above_each_other() -> None:
    boat = load(find("otter"))
    sensors = tuple(replace(row, x_m=0.0, y_m=0.0) for row in boat.sensors)
    picture = ElementTree.fromstring(svg(replace(boat, sensors=sensors)))
    lines = [
        float(text.attrib["y"])
        for text in picture.iter("{http://www.w3.org/2000/svg}text")
        if any((text.text or "").startswith(f"{row.name} ") for row in sensors)
    ]
    assert len(lines) == len(sensors) > 1
    assert min(abs(a - b) for a, b in itertools.combinations(lines, 2)) >= 12.0


def test_a_tunnel_thruster_points_to_starboard_and_hulls_lie_within_the_beam() -> None:
    assert "→  bow: 1.15 m ahead" in characters(load(find("revolt")))
    otter = load(find("otter"))
    assert len(outlines(otter)) == 2
    assert max(abs(y) for line in outlines(otter) for _, y in line) <= 0.5 * otter.beam_m + 1e-9
    assert math.isclose(max(x for line in outlines(otter) for x, _ in line), 1.0)


def test_draw_writes_an_svg(tmp_path: Path) -> None:
    picture = tmp_path / "otter.svg"
    assert main(["draw", "otter", "--svg", str(picture)]) == 0
    assert picture.read_text(encoding="utf-8").startswith("<svg")


def test_numbers_may_have_a_decimal_comma_and_their_unit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "boat.toml"
    assert main(["new", str(file), "--yes", *CATAMARAN, "--length", "1,4 m", "--mass", "31kg", "--lon=-3.2"]) == 0
    boat = load(file)
    assert (boat.length_m, boat.hull.mass_kg, boat.home.lon_deg) == (1.4, 31.0, -3.2)
    said = capsys.readouterr().out
    assert "0.35 m to port" in said and "m astern" in said and "to -" not in said
    assert main(["new", str(tmp_path / "other.toml"), "--yes", *CATAMARAN, "--beam", "wide"]) == 2
    assert "a number, such as 1.2" in capsys.readouterr().err


def test_ctrl_d_in_place_of_an_answer_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It left a traceback."""
    for said in ([], ["", "", "barge", "3", "1", "300", "", "", "", "80", "", "", "", "", ""]):
        answers = iter(said)
        monkeypatch.setattr("sys.stdin.isatty", lambda: True)
        monkeypatch.setattr("builtins.input", lambda *_, answers=answers: _next_or_end(answers))
        assert main(["new", str(tmp_path / "raft.toml")]) == 2 and next(answers, None) is None
        assert capsys.readouterr().err == "companion: new: the answers ended; nothing was written\n"


def _next_or_end(answers: Iterator[str]) -> str:
    for answer in answers:
        return answer
    raise EOFError


def test_a_sign_that_another_one_hides_is_said_in_the_list(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Receiver and inertial sensor lie at the middle of a new boat: neither + nor a stood in the drawing."""
    assert main(["new", str(tmp_path / "boat.toml"), "--yes", *CATAMARAN]) == 0
    said = capsys.readouterr().out
    assert "+  middle of the boat (at the place of b)" in said and "0.3 m up (at the place of b)" in said
    assert "b  imu: 0 m ahead, 0 m to starboard, 0 m up\n" in said
