"""Every kind of decision, made in the browser, and what it does to the session."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import av
import pytest
from playwright.sync_api import Browser, expect

from physagent_studio.program import Edit, SetField, value_at
from physagent_studio.records import Hunk
from physagent_studio.session import Store
from physagent_studio.studio.panels.words import place
from physagent_studio.workbench import commands, probing
from tests.browser.conftest import PATIENCE, Desk, running

pytestmark = [pytest.mark.browser, pytest.mark.usefixtures("shared_scenes")]


@pytest.fixture
def two_hunks(tmp_path: Path, browser: Browser, decided_once: Path) -> Iterator[Desk]:
    """The waiting session with a second hunk in its proposal."""
    root = tmp_path / "workspace"
    shutil.copytree(decided_once, root)
    store = Store(root)
    session = store.open(store.list()[0].id)
    state = session.load()
    head = state.current
    assert head is not None
    assert head.proposal is not None
    name = head.program.scene.objects[1].name
    extra = Hunk(
        id="h9",
        summary=f"make {name} rougher",
        edits=(SetField(path=f"scene.objects.{name}.friction", value=0.9),),
    )
    hunks = tuple(
        hunk.model_copy(update={"edits": _hard_enough(hunk)}) for hunk in head.proposal.hunks
    )
    proposal = head.proposal.model_copy(update={"hunks": (*hunks, extra)})
    changed = head.model_copy(update={"proposal": proposal})
    session.save(state.model_copy(update={"rounds": (changed,)}), checkpoint="test")
    session.close()
    yield from running(root, browser, store.list()[0].id)


def _hard_enough(hunk: Hunk) -> tuple[Edit, ...]:
    """Its edits, with a push that surely reaches the block: a search may end just short of it."""
    reaches = 0.18
    return tuple(
        edit.model_copy(update={"value": reaches}) if edit.path.endswith("magnitude") else edit
        for edit in hunk.edits
    )


def test_beside_accept_stands_what_is_changed(two_hunks: Desk) -> None:
    page, proposal = two_hunks.page, two_hunks.proposal()
    bar, card = (page.get_by_role("group", name=one) for one in ("Decision", "Proposal"))
    field = place(proposal.hunks[-1].edits[0].path)
    expect(bar).to_contain_text(f"{field} its material's → 0.9")
    card.get_by_role("checkbox").last.uncheck()
    expect(bar).not_to_contain_text(field)
    page.locator(".page:not([hidden])").first.evaluate("one => one.scrollTo(0, 0)")
    bar.get_by_title("Show all of it, and why").click()
    expect(card.get_by_text("Because")).to_be_in_viewport()


def test_accept_only_some_hunks(two_hunks: Desk) -> None:
    page = two_hunks.page
    proposal = two_hunks.proposal()
    page.get_by_role("checkbox", name=re.compile("rougher")).click()
    two_hunks.button("Accept selected").click()
    two_hunks.until(lambda: len(two_hunks.snapshot.state.rounds) == 2, "a second round")
    first, second = two_hunks.snapshot.state.rounds
    assert first.decision is not None
    assert first.decision.kind == "accept_hunks"
    kept, dropped = proposal.hunks
    for edit in kept.edits:
        assert value_at(second.program, edit.path) == edit.value
    assert value_at(second.program, dropped.edits[0].path) is None


def test_it_is_shown_what_each_change_is_to_thank_for_and_how_sturdy_it_is(
    two_hunks: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(probing, "RUNS", 6)
    page = two_hunks.page
    two_hunks.proposal()
    two_hunks.button("Accept").click()
    two_hunks.until(lambda: len(two_hunks.snapshot.state.rounds) == 2, "a second round")
    two_hunks.idle()
    page.get_by_role("button", name="Which of these changes brought it about?").click()
    shares = page.get_by_role("list", name="What brought it about").get_by_role("listitem")
    expect(shares).to_have_count(2)
    expect(shares.first).to_contain_text("needed100 %")
    expect(shares.last).to_contain_text("0 %")
    sturdy = page.get_by_role("group", name="How sturdy it is")
    sturdy.get_by_role("button").click()
    expect(sturdy).to_contain_text(re.compile(r"Holds in \d of 6 runs"))
    probed = two_hunks.snapshot.probed
    assert probed is not None
    assert probed.sturdiness is not None
    assert f"Holds in {probed.sturdiness.holds} of 6" in sturdy.inner_text()
    # Another round is another program.
    page.get_by_role("button", name=re.compile("Round 1")).click()
    expect(sturdy).to_have_count(0)


@pytest.fixture
def gentler(tmp_path: Path, browser: Browser, decided_once: Path) -> Iterator[Desk]:
    """The waiting session, as if its proposal made gentler what happens already."""
    root = tmp_path / "workspace"
    shutil.copytree(decided_once, root)
    store = Store(root)
    session = store.open(store.list()[0].id)
    state = session.load()
    head = state.current
    assert head is not None
    assert head.proposal is not None
    proposal = head.proposal.model_copy(update={"factor": "easing"})
    changed = head.model_copy(update={"proposal": proposal})
    session.save(state.model_copy(update={"rounds": (changed,)}), checkpoint="test")
    session.close()
    yield from running(root, browser, store.list()[0].id)


def test_a_gentler_way_is_taken_or_left_and_is_no_repair(gentler: Desk) -> None:
    gentler.proposal()
    card = gentler.page.get_by_role("group", name="Proposal")
    expect(card).to_contain_text("A gentler way")
    expect(card).not_to_contain_text("repair")
    expect(gentler.button("Accept")).to_be_visible()
    expect(gentler.button("Reject")).to_have_count(0)
    gentler.button("Keep as it is").click()
    gentler.until(lambda: gentler.snapshot.state.outcome == "realised", "an end")
    assert len(gentler.snapshot.state.rounds) == 1
    expect(gentler.page.get_by_text("kept as it was")).to_be_visible()


def test_override_with_my_own_edits(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    waiting.button("My numbers").click()
    mine = page.get_by_role("group", name="Your own change")
    path = mine.get_by_label("Which number").first.input_value()
    # Near what was tried out: what is far from it has the planner search for long.
    mine.get_by_label("New value").first.fill("0.23")
    waiting.button("Use mine instead").click()
    waiting.until(lambda: len(waiting.snapshot.state.rounds) == 2, "a second round")
    first, second = waiting.snapshot.state.rounds
    assert first.decision is not None
    assert first.decision.kind == "override"
    assert value_at(second.program, path) == 0.23


def test_an_override_takes_clicks_and_only_what_can_be(waiting: Desk) -> None:
    waiting.proposal()
    waiting.button("My numbers").click()
    mine = waiting.page.get_by_role("group", name="Your own change")
    whose = mine.get_by_label("Of what").first
    expect(whose.locator("option").nth(1)).to_be_attached()
    which = mine.get_by_label("Which number").first
    which.select_option(label="strength")
    value = mine.get_by_label("New value").first
    value.fill("much")
    expect(value).to_have_class("wrong")
    # The panel is drawn anew; what was typed stays, and stays marked.
    mine.get_by_role("button", name="Another number").click()
    expect(mine.get_by_label("New value")).to_have_count(2)
    expect(value).to_have_class("wrong")
    value.fill("-1e99")
    waiting.button("Use mine instead").click()
    expect(waiting.page.get_by_role("alert").first).to_be_visible()
    assert len(waiting.snapshot.state.rounds) == 1
    waiting.page.keyboard.press("Escape")
    expect(mine).to_have_count(0)


@pytest.mark.usefixtures("brief_search")
def test_reject_with_a_reason_and_a_pin_is_respected(waiting: Desk) -> None:
    page = waiting.page
    proposal = waiting.proposal()
    path = proposal.edits[0].path
    page.get_by_role("group", name="Proposal").get_by_role(
        "button", name=re.compile("Pin")
    ).first.click()
    waiting.until(lambda: path in waiting.snapshot.state.pinned, "the pin")
    waiting.button("Reject").click()
    page.get_by_label("Reason").fill("leave the push alone")
    waiting.button("Reject and try again").click()
    waiting.until(
        lambda: (
            waiting.snapshot.busy is None
            and waiting.snapshot.state.current is not None
            and waiting.snapshot.state.current.rejected
        ),
        "the rejection",
    )
    head = waiting.snapshot.state.current
    assert head is not None
    ((rejected, decision),) = head.rejected
    assert rejected.id == proposal.id
    assert decision.reason == "leave the push alone"
    again = head.proposal
    assert again is None or path not in {edit.path for edit in again.edits}


def test_the_verdict_can_be_overruled(waiting: Desk) -> None:
    waiting.proposal()
    waiting.button("I disagree").click()
    waiting.page.get_by_label("Your reason").fill("good <b>enough</b>")
    waiting.button("It happens").click()
    waiting.until(lambda: waiting.snapshot.state.outcome == "realised", "the verdict")
    head = waiting.snapshot.state.current
    assert head is not None
    assert head.override is not None
    assert head.override.words == "good <b>enough</b>"
    assert head.assessment is not None
    assert head.assessment.passed is False
    expect(waiting.page.get_by_text("good <b>enough</b>")).to_be_visible()


@pytest.mark.slow
def test_a_pass_is_overruled_to_a_failure_in_my_words(waiting: Desk) -> None:
    page = waiting.page
    _accept_until_it_happens(waiting)
    assert waiting.snapshot.state.outcome == "realised"
    rounds = len(waiting.snapshot.state.rounds)
    expect(page.get_by_text("The event happens", exact=True)).to_be_visible()
    waiting.button("Save it in another size, or with motion blur").click()
    sizes = page.get_by_role("menu", name="Sizes of the video")
    with page.expect_download(timeout=5000 * PATIENCE) as fetched:
        sizes.get_by_role("menuitem", name="480 × 832").click()
    with av.open(fetched.value.path()) as container:
        assert (container.streams.video[0].width, container.streams.video[0].height) == (480, 832)
    waiting.button("I disagree").click()
    page.get_by_label("Your reason").fill("it is <i>far</i> too slow")
    waiting.button("It does not").click()
    waiting.until(lambda: waiting.snapshot.state.outcome == "running", "the verdict")
    head = waiting.snapshot.state.current
    assert head is not None
    assert head.override is not None
    assert (head.override.passed, head.override.author) == (False, "person")
    assert head.override.words == "it is <i>far</i> too slow"
    assert head.assessment is not None
    assert head.assessment.passed is True, "the measured verdict stays beside it"
    said = (
        "Your verdict: it does not happen (“it is <i>far</i> too slow”)."
        " The checks said: it happens."
    )
    expect(page.get_by_text(said)).to_be_visible()
    expect(page.get_by_text("The event does not happen yet")).to_be_visible()
    # The planner is asked again, and knows what was said.
    waiting.button("Next step").click()
    proposal = waiting.proposal()
    assert len(waiting.snapshot.state.rounds) == rounds
    assert "slow" in proposal.rationale or proposal.question
    waiting.reload()
    expect(page.get_by_text(said)).to_be_visible()


def test_i_give_every_verdict_and_repair_it_myself(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    waiting.button("Done by me: decisions").click()
    for role in ("Verdicts", "Repairs"):
        waiting.button(role).click()
        expect(waiting.button(role)).to_have_attribute("aria-pressed", "true")
    # What is open is still decided; from then on it is my turn wherever I play.
    waiting.button("Accept").click()
    mine = page.get_by_role("group", name="Your verdict")
    expect(mine).to_contain_text("Does the scene match the photo?")
    waiting.button("It matches").click()
    expect(mine).to_contain_text("Does the event happen?")
    expect(waiting.button("Run to the end")).to_be_disabled()
    waiting.reload()
    mine.get_by_label("Your reason").fill("a bit late")
    waiting.button("It does not").click()
    expect(page.get_by_role("group", name="Your repair")).to_be_visible()
    waiting.idle()
    head = waiting.snapshot.state.current
    assert head is not None
    assert head.ruling is not None
    assert (head.ruling.passed, head.ruling.words) == (False, "a bit late")
    assert (waiting.snapshot.state.phase, head.proposal) == ("propose", None)
    # My edit is the next round, and the next verdict is mine again.
    waiting.workbench.post(
        commands.ApplyEdits((SetField(path="clip.playback_fps", value=20.0),), "by hand")
    )
    waiting.idle()  # a click made before the page knows of the edits would be refused as stale
    waiting.button("Run my edits").click()
    expect(mine).to_contain_text("Does the scene match the photo?")
    waiting.idle()
    assert [one.author for one in waiting.snapshot.state.rounds][-1] == "person"
    waiting.button("Done by me: decisions, verdicts, repairs").click()
    waiting.button("Verdicts").click()
    waiting.button("Repairs").click()
    expect(mine).to_be_hidden()
    waiting.until(lambda: waiting.snapshot.state.by_hand == (), "the agent plays all roles")


def _accept_until_it_happens(desk: Desk) -> None:
    """Accepts one proposal after another, by hand."""
    desk.proposal()
    for _ in range(9):
        count = len(desk.snapshot.state.rounds)
        desk.button("Accept").click()
        desk.until(lambda count=count: len(desk.snapshot.state.rounds) > count, "the next round")
        desk.idle()
        if desk.snapshot.state.phase == "done":
            return


def test_by_hand_to_success_then_fork_and_compare(waiting: Desk) -> None:
    page = waiting.page
    _accept_until_it_happens(waiting)
    assert waiting.snapshot.state.outcome == "realised"
    expect(page.get_by_text("The event happens", exact=True)).to_be_visible()
    done = waiting.snapshot.state
    # Back to the first round, read-only, compared, then on from there.
    shown = len(done.rounds)
    expect(page.get_by_role("button", name=f"Compare with round {shown}")).to_have_count(0)
    page.get_by_role("button", name=re.compile("Compare with round 1")).click()
    expect(page.get_by_text("Compared with round 1")).to_be_in_viewport()
    # What was edited by hand does not go along into another branch.
    edit = SetField(path="clip.playback_fps", value=20.0)
    waiting.workbench.post(commands.ApplyEdits((edit,), "by hand"))
    waiting.until(lambda: waiting.snapshot.has_draft, "the edit")
    waiting.idle()
    page.get_by_role("list", name="History").get_by_role(
        "button", name=re.compile("Round 1")
    ).first.click()
    expect(page.get_by_text("Round 1 is open read-only.")).to_be_visible()
    expect(page.get_by_role("group", name="Proposal")).to_have_count(0)
    waiting.button("Go on from here").click()
    waiting.until(lambda: waiting.snapshot.state.head == done.rounds[0].id, "the fork")
    assert len(waiting.snapshot.state.rounds) == len(done.rounds)
    assert not waiting.snapshot.has_draft
    waiting.proposal()


def test_twenty_quick_clicks_are_one_decision(waiting: Desk) -> None:
    waiting.proposal()
    accept = waiting.button("Accept")
    accept.evaluate("button => { for (let i = 0; i < 20; i += 1) button.click(); }")
    waiting.until(lambda: len(waiting.snapshot.state.rounds) > 1, "a second round")
    waiting.idle()
    first = waiting.snapshot.state.rounds[0]
    children = [one for one in waiting.snapshot.state.rounds if one.parent == first.id]
    assert len(children) == 1


@pytest.fixture
def compared(tmp_path: Path, browser: Browser, decided_once: Path) -> Iterator[Desk]:
    """The waiting session with the 3D scene drawn."""
    root = tmp_path / "workspace"
    shutil.copytree(decided_once, root)
    yield from running(root, browser, Store(root).list()[0].id, scene=True)


def test_comparing_shows_values_diff_curves_and_a_ghost(compared: Desk) -> None:
    page = compared.page
    proposal = compared.proposal()
    compared.button("Accept").click()
    compared.until(lambda: len(compared.snapshot.state.rounds) == 2, "a second round")
    compared.idle()
    page.get_by_role("button", name="Compare with round 1").click()
    diff = page.get_by_role("group", name="What changed from round 1")
    expect(diff.locator(".del").first).to_be_visible()
    expect(diff.locator(".add").first).to_be_visible()
    field = place(proposal.edits[0].path).rpartition(" · ")[2]
    assert any(word in str(diff.text_content()) for word in (field, "aside", "strength"))
    expect(page.get_by_text("round 1", exact=True)).to_be_visible()

    def ghosts() -> list[str]:
        found = "() => Object.keys(window.__viserMutable?.nodeRefFromName || {})"
        views = [one for one in page.frames if "/viewer/" in one.url]
        names = views[0].evaluate(found) if views else []
        return [one for one in names if "ghost" in one and "earlier" in one]

    compared.until(ghosts, "the ghost of round 1")
    compared.button("Curves").click()
    curves = page.locator("#page-plots svg").first
    count = len(compared.snapshot.program.scene.objects)
    expect(curves.locator("path[stroke-dasharray]")).to_have_count(count)
    expect(curves.locator("path:not([stroke-dasharray])")).to_have_count(count)
    expect(page.get_by_text("Dashed: the round compared with.")).to_be_visible()
    page.get_by_role("tab", name="Rounds").click()
    compared.button("Close").click()
    expect(diff).to_have_count(0)


@pytest.fixture
def empty(tmp_path: Path, browser: Browser) -> Iterator[Desk]:
    """A studio with nothing opened yet."""
    yield from running(tmp_path / "workspace", browser)


def _tab_to(desk: Desk, words: str) -> None:
    """Presses Tab until what has the focus says these words."""
    for _ in range(60):
        desk.page.keyboard.press("Tab")
        said = desk.page.evaluate("document.activeElement.textContent")
        if words in said:
            return
    raise AssertionError(f"Tab never comes to '{words}'")


@pytest.mark.usefixtures("brief_search")
def test_keyboard_only_from_the_opening_page_to_acceptance(empty: Desk, decided_once: Path) -> None:
    store = Store(decided_once)
    session = store.open(store.list()[0].id)
    event = session.case.event.replace("_", " ")
    session.close()
    page = empty.page
    page.keyboard.press("o")
    expect(page.get_by_role("dialog", name="Open")).to_be_visible()
    _tab_to(empty, event)
    page.keyboard.press("Enter")
    empty.until(lambda: empty.snapshot.program.scene.objects, "the scene", 2 * PATIENCE)
    empty.idle()
    page.keyboard.press("r")
    empty.proposal()
    page.keyboard.press("a")
    empty.until(lambda: len(empty.snapshot.state.rounds) == 2, "a second round")
    first = empty.snapshot.state.rounds[0]
    assert first.decision is not None
    assert first.decision.kind == "accept"


def test_the_keys_of_looking_and_of_the_palette(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    page.keyboard.press("End")
    waiting.until(
        lambda: waiting.studio.view.step == waiting.snapshot.program.clip.steps, "the end"
    )
    page.keyboard.press("Home")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    waiting.until(lambda: waiting.studio.view.frame(waiting.snapshot.program.clip) == 2, "frame 2")
    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="Keys")).to_be_visible()
    page.keyboard.press("Escape")
    page.keyboard.press("Control+k")
    page.keyboard.type("accept the")
    page.keyboard.press("Enter")
    waiting.until(lambda: len(waiting.snapshot.state.rounds) == 2, "a second round")
