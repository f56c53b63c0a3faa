"""How the 3D view draws: lightly where a processor has to, and as one chooses."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Frame, Route, expect

from physagent_studio.program import SetField
from physagent_studio.session import Store
from physagent_studio.workbench import commands
from tests.browser.conftest import PATIENCE, Desk, Hard, running
from tests.browser.in_scene import view_of

pytestmark = pytest.mark.browser

PICTURE = """() => {
  const m = window.__viserMutable, gl = m.canvas.getContext('webgl2');
  let shadows = 0;
  m.scene.traverse(one => { if (one.isLight && one.castShadow) shadows += 1; });
  let solid = null;
  m.nodeRefFromName['/backdrop']?.traverse(one => { if (one.material?.map) solid = !one.material.transparent; });
  return {
    light: window.studioDrawing.light, renderer: window.studioDrawing.renderer, shadows,
    smooth: gl.getContextAttributes().antialias, sky: Boolean(m.scene.environment),
    behind: m.backgroundMaterial.visible, solid, fine: m.canvas.width / m.canvas.clientWidth,
    shown: m.canvas.style.opacity, objects: Boolean(m.nodeRefFromName['/objects/red_ball']),
  };
}"""  # noqa: E501 - a script of the page


@pytest.fixture
def desk(tmp_path: Path, browser: Browser, hard: Hard) -> Iterator[Desk]:
    root = tmp_path / "workspace"
    shutil.copytree(hard.opened, root)
    yield from running(root, browser, Store(root).list()[0].id, scene=True)


def _picture(desk: Desk, view: Frame, **wanted: Any) -> dict[str, Any]:
    """What is drawn, once the scene is there and it is as wanted."""

    def found() -> dict[str, Any] | None:
        now = view.evaluate(PICTURE)
        there = now["objects"] and now["shown"] in ("", "1")
        return now if there and all(now[key] == value for key, value in wanted.items()) else None

    return desk.until(found, f"a picture with {wanted}")


def test_a_processor_draws_lightly_and_finely_at_rest(desk: Desk) -> None:
    view = view_of(desk)
    now = _picture(desk, view, fine=pytest.approx(1.5, abs=0.01), solid=True)
    assert now["light"]
    assert now["renderer"]
    assert not now["smooth"]
    assert not now["sky"]
    assert now["shadows"] == 0
    assert not now["behind"]

    # While something is asked for, it has no more pixels than the page.
    def moved() -> bool:
        view.evaluate("() => window.__viserMutable.requestRender()")
        return view.evaluate(PICTURE)["fine"] <= 1.01

    desk.until(moved, "coarser in motion")
    _picture(desk, view, fine=pytest.approx(1.5, abs=0.01))


def test_what_is_chosen_is_drawn_and_remembered(desk: Desk) -> None:
    view_of(desk)
    desk.tab("Scene")
    desk.page.get_by_label("How to draw").select_option("with all it has")
    view = desk.until(
        lambda: next((one for one in desk.page.frames if one.url.endswith("/?full")), None),
        "the view, opened anew",
    )
    view.wait_for_function("() => window.__viserMutable?.camera", timeout=1000 * PATIENCE)
    now = _picture(desk, view, solid=False)
    assert not now["light"]
    assert now["smooth"]
    desk.reload()
    desk.tab("Scene")
    assert desk.page.get_by_label("How to draw").input_value() == "full"


def test_what_deforms_wears_the_photo(desk: Desk) -> None:
    """viser has no textured mesh that bends: ours puts on the texture of its hidden rigid form."""
    soft = SetField(path="scene.objects.red_ball.body", value={"kind": "soft"})
    desk.workbench.post(commands.ApplyEdits((soft,), "soft"))
    desk.until(lambda: desk.snapshot.rollout and desk.snapshot.rollout.vertices, "a soft ball")
    view = view_of(desk)
    worn = """() => {
      const nodes = window.__viserMutable.nodeRefFromName;
      window.__viserMutable.requestRender();
      let drawn = null;
      nodes['/deforming/red_ball/0']?.traverse(one => { if (!drawn && one.isMesh) drawn = one; });
      const map = drawn?.material.map, uv = drawn?.geometry.attributes.uv;
      return map && uv?.count === drawn.geometry.attributes.position.count ? map.image.width : 0;
    }"""
    wide = desk.until(lambda: view.evaluate(worn), "the photo on it")
    scene = desk.snapshot.scene
    assert scene is not None
    texture = scene.meshes["red_ball"].texture
    assert texture is not None
    assert wide == texture.shape[1]


def test_the_photo_stands_in_until_the_scene_is_drawn_as_a_whole(desk: Desk) -> None:
    page = desk.page

    def patient(route: Route) -> None:
        """The page without its own limit to how long the photo may stand in."""
        answer = route.fetch()
        limit, other = "const LONGEST = 15000;", "const LONGEST = Infinity;"
        assert limit in answer.text()
        route.fulfill(response=answer, body=answer.text().replace(limit, other))

    page.route("**/photo.js", patient)
    page.reload()
    page.wait_for_function(
        "() => document.querySelectorAll('img.awaited[src]')[0]?.hidden",
        timeout=1000 * PATIENCE,
    )
    names = [f"/objects/{one.name}" for one in desk.snapshot.program.scene.objects]
    drawn = "names => document.getElementById('viewer').contentWindow.studioDrawn(names)"
    assert page.evaluate(drawn, ["/around/beyond/0", *names])
    # Another look loads the viewer anew.
    page.keyboard.press("d")
    expect(page.locator("img.awaited")).to_be_visible()
    expect(page.locator("img.awaited")).to_be_hidden()
