"""What the photo's tools offer for a click."""

from physagent_studio.benchmark.lookalikes import stack
from physagent_studio.program.scene import Click, Grounding
from physagent_studio.studio.photo_desk import PhotoDesk


def _clicked(mask):
    rows, columns = mask.nonzero()
    return Grounding(points=(Click(x=float(columns.mean()), y=float(rows.mean()), label=1),))


def test_a_layer_of_a_stack_leads_the_masks_on_offer():
    drawn = stack(11)
    said = [(name, _clicked(mask)) for name, mask in drawn.masks.items()]
    name = said[1][0]
    desk = PhotoDesk()
    first = desk.masks(drawn.image, name, said, whole=False)
    assert first["more"]
    assert not any(mask["layer"] for mask in first["masks"])
    led = desk.masks(drawn.image, name, said)["masks"]
    assert [mask["layer"] for mask in led] == [True] + [False] * (len(led) - 1)
    # What the grounding has to say: the layer comes of itself, the others are counted without it.
    assert [mask["candidate"] for mask in led] == [0, *range(len(led) - 1)]
    assert desk.masks(drawn.image, name, said) == {"name": name, "masks": led, "more": False}
    assert led[1:] == first["masks"]
    # What a person has chosen is no part of the stack any more.
    own = dict(said)[name].model_copy(update={"settled": True})
    alone = desk.masks(drawn.image, name, [(key, own if key == name else s) for key, s in said])
    assert [mask["layer"] for mask in alone["masks"]] == [False] * len(alone["masks"])
    assert [mask["candidate"] for mask in alone["masks"]] == list(range(len(alone["masks"])))
