"""The way of a newcomer: step a round, edit one number of the proposal, accept, look, reload."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.browser.conftest import Desk

pytestmark = [pytest.mark.browser, pytest.mark.usefixtures("shared_scenes", "brief_search")]


SECOND_CLICK = """() => new Promise(done => {
  const named = (name) =>
    [...document.querySelectorAll('button')].find(one => one.textContent === name);
  const watch = new MutationObserver(() => {
    if (!named('Cancel')) return;
    watch.disconnect();
    named('Cancel').click();
    done();
  });
  watch.observe(document.body, { subtree: true, childList: true, characterData: true });
  named('Start').click();
})"""
"""Starts, and clicks Cancel as soon as it is there, where the pointer may be already."""


def test_the_second_of_two_clicks_on_start_does_not_end_it(fresh: Desk) -> None:
    fresh.page.evaluate(SECOND_CLICK)
    fresh.proposal()
    assert fresh.snapshot.rollout is not None


def test_step_edit_accept_and_reload(fresh: Desk) -> None:
    page = fresh.page
    fresh.button("Start").click()
    proposal = fresh.proposal()
    before = fresh.snapshot.rollout
    assert before is not None
    assert proposal.edits

    fresh.button("Edit").click()
    field = page.get_by_role("group", name="Proposal").locator(".nums input").first
    old = float(field.input_value())
    field.fill(str(round(old * 1.15, 4)))
    fresh.button("Accept edited").click()

    fresh.until(lambda: len(fresh.snapshot.state.rounds) == 2, "a second round")
    fresh.idle()
    after = fresh.snapshot.rollout
    assert after is not None
    assert not np.array_equal(before.positions, after.positions)
    first, second = fresh.snapshot.state.rounds
    assert first.decision is not None
    assert first.decision.kind == "edit"
    assert second.program != first.program
    expect(page.get_by_role("list", name="History").get_by_role("listitem")).to_have_count(2)

    held = fresh.snapshot
    fresh.reload()
    expect(page.get_by_role("list", name="History").get_by_role("listitem")).to_have_count(2)
    expect(page.get_by_text(held.program.event.prompt).first).to_be_visible()
    assert fresh.snapshot.state == held.state
