"""At usual sizes, light and dark: no enabled control is clipped, covered or too small to hit."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page

from tests.browser.conftest import DRAWN, Desk

pytestmark = pytest.mark.browser

SIZES = ((1280, 720), (1440, 900), (1920, 1080))
LOOKS = (*((size, False) for size in SIZES), (SIZES[0], True))
"""Sizes and whether dark, which changes colours alone: it is looked at where room is scarcest."""

AMISS = """() => {
  const shown = (one) => !one.disabled && one.checkVisibility({ visibilityProperty: true }) && !one.closest('#viewer, [hidden]');
  const top = document.querySelector('.shade') || document;
  const said = (one) => `${one.tagName} ${one.getAttribute('aria-label') || one.textContent.trim().slice(0, 40) || one.title}`;
  const found = [];
  const controls = [...top.querySelectorAll('button, select, input:not([type=file]), textarea, summary, [role=button], [role=tab]')].filter(shown);
  for (const one of controls) {
    const target = one.matches('input[type=checkbox], input[type=radio]') ? one.closest('label, .row') || one : one;
    one.scrollIntoView({ block: 'nearest', inline: 'nearest' });
    const box = target.getBoundingClientRect();
    if (!box.width || !box.height) continue;
    if (!one.matches('.link, .plain, .r') && (box.height < 23.5 || box.width < 23.5)) found.push(`small ${Math.round(box.width)}x${Math.round(box.height)}: ${said(one)}`);
    const at = one.getBoundingClientRect(), [x, y] = [at.left + at.width / 2, at.top + at.height / 2];
    if (box.left < -1 || box.right > innerWidth + 1 || y < 0 || y > innerHeight) { found.push(`outside: ${said(one)}`); continue; }
    const hit = document.elementFromPoint(x, y);
    if (!hit || !(target.contains(hit) || hit.contains(one) && hit.closest('label'))) found.push(`covered by ${hit?.tagName}.${hit?.className?.baseVal ?? hit?.className}: ${said(one)}`);
  }
  // Words that end in an ellipsis, or are cut without one.
  for (const one of top.querySelectorAll('button, .title, .clip, .head, .chip, .label, h1, h2, h3, option:checked')) {
    if (!shown(one) || one.closest('.evidence') || !one.textContent.trim()) continue;
    if (one.scrollWidth > one.clientWidth + 1 && (one.matches('button') || getComputedStyle(one).overflowX !== 'visible') && !one.matches('.mono')) found.push(`cut: ${said(one)}`);
  }
  for (const one of top.querySelectorAll('[aria-pressed], input[type=checkbox]')) {
    if (shown(one) && !one.closest('[title]') && !one.querySelector('[title]')) found.push(`no tooltip: ${said(one)}`);
  }
  return [...new Set(found)];
}"""  # noqa: E501
"""Enabled controls that are under 24 pixels, out of the window, or lie below something else, and
words that are cut; toggles that do not say what they do."""


def themed(page: Page, size: tuple[int, int], *, dark: bool) -> None:
    """Gives the page a size and a theme."""
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.evaluate(
        "name => { document.documentElement.dataset.theme = name }", "dark" if dark else "light"
    )
    # What is drawn to the size of its place is drawn anew in the frame after that changes.
    page.evaluate(DRAWN)


def _select(kind: str, name: str) -> str:
    return f"import('/wire.js').then(w => w.send({{do: 'select', kind: '{kind}', name: '{name}'}}))"


def _panels(desk: Desk) -> dict[str, Callable[[], None]]:
    """What there is to see, by name, and how to get there."""
    page, program = desk.page, desk.snapshot.program

    def inspect(kind: str, name: str) -> None:
        page.evaluate(_select(kind, name))
        desk.tab("Inspector")
        desk.heard()

    def dialog(open_it: Callable[[], None]) -> None:
        open_it()
        page.locator(".shade").first.wait_for()

    return {
        "rounds": lambda: desk.tab("Rounds"),
        "plots": lambda: desk.tab("Plots"),
        "edit": lambda: (desk.tab("Rounds"), desk.button("Edit").click())[0],
        "override": lambda: desk.button("My numbers").click(),
        "reject": lambda: desk.button("Reject").click(),
        "overrule": lambda: desk.button("I disagree").click(),
        "photo": lambda: desk.tab("Photo"),
        "scene": lambda: desk.tab("Scene"),
        "program": lambda: desk.tab("Program"),
        "thing": lambda: inspect("object", program.scene.objects[0].name),
        "support": lambda: inspect("support", program.scene.supports[0].name),
        "action": lambda: inspect("action", program.event.actions[0].id),
        "demand": lambda: inspect("statement", program.contract.statements[0].id),
        "camera": lambda: inspect("camera", ""),
        "clip": lambda: inspect("clip", ""),
        "open": lambda: dialog(lambda: desk.button("Open…").click()),
        "new": lambda: dialog(lambda: page.keyboard.press("Shift+O")),
        "keys": lambda: dialog(lambda: page.keyboard.press("?")),
        "palette": lambda: dialog(lambda: page.keyboard.press("Control+k")),
    }


def test_everything_can_be_hit_and_read(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    amiss = {}
    for name, go in _panels(waiting).items():
        themed(page, SIZES[0], dark=False)
        go()
        page.wait_for_function("() => document.fonts.status === 'loaded'")
        for size, dark in LOOKS:
            themed(page, size, dark=dark)
            amiss[name, size, dark] = page.evaluate(AMISS)
        for _ in range(2):
            page.keyboard.press("Escape")
        page.evaluate("document.activeElement?.blur()")
    assert {name: found for name, found in amiss.items() if found} == {}
