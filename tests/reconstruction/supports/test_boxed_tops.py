"""The top of a table from a box around all of it."""

import cv2
import numpy as np
import pytest

from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.reconstruction.supports.boxed_tops import top_in_box

TOP = ((60, 250), (770, 250), (670, 170), (160, 170))
BOX = (58.0, 168.0, 772.0, 460.0)
FEET = [(300.0, 220.0), (600.0, 230.0)]


def _table(top_colour=(180, 140, 90), turn=0):
    """A table of plain colours on legs before a wall; turn: rows its right end is lower by."""
    image = np.full((480, 832, 3), 200, np.uint8)
    lower = np.array([(x, y + turn * x / 832) for x, y in TOP])
    front = [*lower[:2], *(lower[1::-1] + np.array([0, 18]))]
    for corners, colour in ((lower, top_colour), (front, (110, 80, 50))):
        points = np.round(np.array(corners)).astype(np.int32)
        cv2.fillPoly(image, [points], colour, cv2.LINE_AA)
    for x in (90, 720):
        cv2.rectangle(image, (x, 268), (x + 30, 460), (100, 70, 40), -1)
    return image


def test_the_corners_are_the_ends_of_the_far_edge_and_the_sides_of_the_box_at_the_near_one():
    corners = top_in_box(segments(_table()), BOX, FEET, 832)
    assert corners is not None
    assert np.array(corners) == pytest.approx(np.array(TOP), abs=4)


def test_a_far_edge_that_is_not_seen_is_taken_along_the_top_of_the_box():
    corners = top_in_box(segments(_table((200, 200, 200))), BOX, FEET, 832)
    assert corners is not None
    assert [y for _, y in corners] == pytest.approx([250, 250, 168, 168], abs=3)
    assert corners[3][0] > corners[0][0]


@pytest.mark.parametrize(("turn", "feet"), [(160, FEET), (0, []), (0, [(300.0, 300.0)])])
def test_nothing_is_said_of_a_table_askew_or_without_anything_on_it(turn, feet):
    assert top_in_box(segments(_table(turn=turn)), BOX, feet, 832) is None
