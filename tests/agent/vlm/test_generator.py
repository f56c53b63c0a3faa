"""The generator: what it asks, what it accepts, and what goes back to the model."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import Any

import pytest

from physagent_studio.agent.vlm import VlmGenerator
from physagent_studio.agent.vlm.messages import NoAnswer
from physagent_studio.errors import InputError
from physagent_studio.program import (
    Click,
    Support,
)
from tests.agent.vlm import scripted, world
from tests.agent.vlm.helpers import Connect, Serve, replies


def test_the_generator_asks_for_the_scene_and_then_with_figures_for_the_event(
    serve: Serve, connect: Connect
) -> None:
    server = serve(replies(scripted.scene(), scripted.event()))
    first = VlmGenerator(connect(server)).first(world.CASE, world.reconstruct)
    assert [asked.form for asked in server.asked] == ["SceneReply", "EventReply"]
    assert all(len(asked.pictures) == 1 for asked in server.asked)
    assert world.SENTENCE in server.asked[0].text("user")
    assert "extent [0.2, 0.2, 0.2] m; at [-1, 3, 0.1]" in server.asked[1].text("user")
    assert first.scene.is_resolved
    assert first.event.prompt == world.SENTENCE
    assert first.scene.objects[0].grounding == world.CASE.objects[0][1]


def test_points_on_a_picture_that_was_made_smaller_are_scaled_back(
    serve: Serve, connect: Connect
) -> None:
    import numpy as np

    large = replace(world.CASE, image=np.zeros((480, 640, 3), np.uint8), objects=())
    server = serve(replies(scripted.scene(), scripted.event()))
    line = connect(server, picture_side=320)
    first = VlmGenerator(line).first(large, world.reconstruct)
    assert "320 × 240 pixels" in server.asked[0].text("user")
    assert first.scene.objects[0].grounding.points == (Click(x=40, y=60),)


def test_a_ground_is_always_there(serve: Serve, connect: Connect) -> None:
    bare = scripted.scene() | {"supports": []}
    case = replace(world.CASE, supports=(Support(name="lawn"),))
    for one, wanted in ((world.CASE, ["floor"]), (case, ["lawn"])):
        seen = bare if one is world.CASE else json.loads(json.dumps(bare).replace("floor", "lawn"))
        server = serve(replies(seen, scripted.event()))
        first = VlmGenerator(connect(server)).first(one, world.reconstruct)
        assert [item.name for item in first.scene.supports] == wanted


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"objects": [scripted.scene()["objects"][0] | {"name": "cat"}]}, "marked ball"),
        ({"objects": [scripted.scene()["objects"][0] | {"support": "moon"}]}, "no support 'moon'"),
        (
            {"objects": [scripted.scene()["objects"][0] | {"material": "mithril"}]},
            "objects.ball.material: there is no material 'mithril'",
        ),
        ({"scale_reference": "cat"}, "there is no object 'cat'"),
        (
            {"objects": [*scripted.scene()["objects"], {"name": "cup", "material": "glass"}]},
            "cup.points: needs a point with label 1",
        ),
        (
            {
                "objects": [
                    *scripted.scene()["objects"],
                    {"name": "cup", "material": "glass", "points": [{"x": 640, "y": 1}]},
                ]
            },
            r"\(640, 1\) lies outside the picture \(0 to 64, 0 to 48\)",
        ),
        (
            {"objects": [*scripted.scene()["objects"]] * 2},
            "scene.objects.ball: the name is used twice",
        ),
    ],
)
def test_the_model_hears_exactly_what_is_wrong_and_may_correct_it(
    change: dict[str, Any], message: str, serve: Serve, connect: Connect
) -> None:
    server = serve(replies(scripted.scene() | change, scripted.scene(), scripted.event()))
    VlmGenerator(connect(server)).first(world.CASE, world.reconstruct)
    told = server.asked[1].body["messages"][-1]["content"]
    assert "Your reply was not accepted" in told

    assert re.search(message, told)
    assert server.asked[1].body["messages"][-2]["role"] == "assistant"


def test_a_scene_that_cannot_be_reconstructed_goes_back_to_the_model(
    serve: Serve, connect: Connect
) -> None:
    tries: list[int] = []

    def reconstruct(state: Any) -> Any:
        tries.append(1)
        if len(tries) == 1:
            raise InputError("the click (20, 30) on 'ball' lies on nothing")
        return world.reconstruct(state)

    server = serve(replies(scripted.scene(), scripted.scene(), scripted.event()))
    VlmGenerator(connect(server)).first(world.CASE, reconstruct)
    assert "lies on nothing" in server.asked[1].text("user")


def test_after_two_more_attempts_it_ends(serve: Serve, connect: Connect) -> None:
    server = serve(replies({"objects": []}))
    with pytest.raises(NoAnswer, match=r"generator\.scene after 3 attempts: .*objects"):
        VlmGenerator(connect(server)).first(world.CASE, world.reconstruct)
    assert [asked.again for asked in server.asked] == [0, 1, 2]


def test_an_event_passes_the_same_validation_as_a_program_by_hand(
    serve: Serve, connect: Connect
) -> None:
    late = scripted.event()
    late["actions"][0]["start_step"] = 4000
    stray = scripted.event()
    stray["statements"][0]["subject"] = "cat"
    server = serve(replies(scripted.scene(), late, stray, scripted.event()))
    VlmGenerator(connect(server)).first(world.CASE, world.reconstruct)
    assert "event.actions.push.start_step" in server.asked[2].text("user")
    assert "there is no object 'cat'" in server.asked[3].text("user")


def held() -> dict[str, Any]:
    """A push of what is held in place: valid, and probably not meant."""
    hold = {"id": "hold", "operator": "FixObject", "name": "ball", "duration": 50}
    force = {"magnitude": 3.0, "direction": "right"}
    push = {"id": "push", "operator": "ApplyForce", "name": "ball", "force": force, "duration": 5}
    return scripted.event() | {"actions": [hold, push]}


def test_what_preflight_doubts_is_said_once(serve: Serve, connect: Connect) -> None:
    server = serve(replies(scripted.scene(), held(), scripted.event()))
    first = VlmGenerator(connect(server)).first(world.CASE, world.reconstruct)
    told = server.asked[2].body["messages"][-1]["content"]
    assert "will probably not do what is meant" in told
    assert [item.id for item in first.event.actions] == ["push"]


@pytest.mark.parametrize("after", [held(), "well"])
def test_a_program_that_is_meant_so_stands(after: Any, serve: Serve, connect: Connect) -> None:
    """Whether it comes again, or nothing better comes."""
    server = serve(replies(scripted.scene(), held(), after))
    first = VlmGenerator(connect(server)).first(world.CASE, world.reconstruct)
    assert [item.id for item in first.event.actions] == ["hold", "push"]


def test_without_a_photo_it_says_so(serve: Serve, connect: Connect) -> None:
    bare = replace(world.CASE, image=None)
    with pytest.raises(InputError, match="works from a photo"):
        VlmGenerator(connect(serve(replies("")))).first(bare, world.reconstruct)
