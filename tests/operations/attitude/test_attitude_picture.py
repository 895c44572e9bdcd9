"""A calibration is drawn whatever was measured, and by text alone."""

from xml.etree import ElementTree as ET

from hypothesis import given
from hypothesis import strategies as st

from lbr.operations.attitude.picture import MOST_DRAWN, SIZE, Drawing, save, svg

SVG = "{http://www.w3.org/2000/svg}"
points = st.lists(st.tuples(st.floats(), st.floats()), max_size=30)


def dots(text: str) -> list[tuple[float, float]]:
    found = ET.fromstring(text).iter(f"{SVG}circle")
    return [(float(one.attrib["cx"]), float(one.attrib["cy"])) for one in found]


def test_a_picture_has_a_dot_for_each_point_about_its_middle(tmp_path):
    path = tmp_path / "mag.svg"
    save(Drawing(title="a <b> & c", measured=[(20.0, 0.0), (0.0, 20.0)], corrected=[(0.0, -20.0)]), path)
    text = path.read_text(encoding="utf-8")
    right, above, below = dots(text)
    assert right == (SIZE - above[1], SIZE / 2)
    assert above[0] == below[0] == SIZE / 2
    assert above[1] < below[1]
    assert ET.fromstring(text).findtext(f"{SVG}title") == "a <b> & c"
    assert list(tmp_path.iterdir()) == [path]


@given(measured=points, corrected=points, title=st.text(st.characters(categories=["L", "P"])))
def test_whatever_was_measured_is_drawn_within_the_picture(measured, corrected, title):
    assert all(
        0 <= one <= SIZE
        for dot in dots(svg(Drawing(title=title, measured=measured, corrected=corrected)))
        for one in dot
    )


def test_of_very_many_points_some_are_drawn():
    many = [(float(number), 1.0) for number in range(10 * MOST_DRAWN)]
    assert 0 < len(dots(svg(Drawing(title="", measured=many, corrected=[])))) <= MOST_DRAWN
