"""What the photo's tools offer for a click."""

from physagent_studio.benchmark.reconstruction.lookalikes import stack
from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.studio import photo_desk
from physagent_studio.studio.photo_desk import PhotoDesk


def _clicked(mask):
    rows, columns = mask.nonzero()
    return Grounding(points=(Click(x=float(columns.mean()), y=float(rows.mean()), label=1),))


def test_a_layer_of_a_stack_leads_the_masks_on_offer():
    drawn = stack(9)
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


def test_what_takes_long_is_shown_early_and_found_again_in_the_end(monkeypatch):
    drawn = stack(9)
    said = [(name, _clicked(mask)) for name, mask in drawn.masks.items()]
    name = said[1][0]
    told = []

    def masks(after):
        monkeypatch.setattr(photo_desk, "EARLY", after)
        told.clear()
        return PhotoDesk().masks(drawn.image, name, said, whole=False, early=told.append)

    quick = masks(3600)
    assert not told
    assert "now" not in quick
    slow = masks(-1)
    (early,) = told  # once, whatever is found after it
    assert early["early"]
    assert len(early["masks"]) == 4
    assert slow["masks"] == quick["masks"]
    assert len(slow["now"]) == 4
    for mask, now in zip(early["masks"], slow["now"], strict=True):
        if mask in slow["masks"]:
            assert slow["masks"][now]["path"] == mask["path"]
    assert any(now >= 0 for now in slow["now"])
    # Nobody waits any more: nothing is shown.
    told.clear()
    PhotoDesk().masks(drawn.image, name, said, whole=False, stop=lambda: True, early=told.append)
    assert not told
