"""Pictures: the photo at frame 0, shadows as a change, supports in front, odd poses."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import trimesh

from physagent_studio.errors import Cancelled, InputError
from physagent_studio.program.rotations import about_axis
from physagent_studio.program.scene.camera import Camera
from physagent_studio.records.scene import Mesh
from physagent_studio.rendering import Compositor, compositor, render_clip
from physagent_studio.rendering.compositor import initial_poses
from physagent_studio.rendering.scenery import Scenery
from tests.rendering.scenes import FLOOR, SIZE, ball, crate, mesh_of, rollout_of, scene_of, table


def photographed(item, mesh, supports=(), support_meshes=None, seed=0):
    """The object of a random photo, textured from it; the plate is plain grey."""
    camera = Camera.from_horizon(SIZE, 30, 1.2)
    rng = np.random.default_rng(seed)
    coarse = rng.integers(30, 226, (SIZE[1] // 4, SIZE[0] // 4, 3), np.uint8)
    photo = np.asarray(cv2.resize(coarse, SIZE, interpolation=cv2.INTER_CUBIC), np.uint8)
    world = mesh.vertices + np.array(item.position)
    uv, _ = camera.project(world)
    plate = np.full_like(photo, 128)
    textured = Mesh(mesh.vertices, mesh.faces, uv, photo)
    bare = scene_of([item], {item.name: textured}, supports, support_meshes)
    mask = Compositor(bare).frame().ids == 0
    photo = np.where(mask[..., None], photo, plate)
    return scene_of(
        [item],
        {item.name: textured},
        supports,
        support_meshes,
        photo=photo,
        plate=plate,
        masks={item.name: mask},
    )


def test_first_frame_is_the_photo():
    scene = photographed(*ball((0.0, 2.5, 0.3), 0.3), supports=[FLOOR])
    frame = Compositor(scene).frame()
    mask = scene.masks["ball"]
    inner = cv2.erode(mask.astype(np.uint8), np.ones((3, 3))) > 0
    assert inner.sum() > 600
    difference = np.abs(frame.rgb.astype(int) - scene.photo)
    assert difference[inner].max() <= 3
    assert difference[inner].mean() < 0.7
    outside = cv2.dilate(mask.astype(np.uint8), np.ones((3, 3))) == 0
    assert difference[outside].max() == 0


def test_texture_travels_with_the_object():
    scene = photographed(*crate((0.0, 2.5, 0.2), (0.4, 0.4, 0.4)), supports=[FLOOR])
    compositor = Compositor(scene)
    positions, rotations = initial_poses(scene)
    # To keep both size and shape on the picture, move in the image plane.
    shift = np.array([[0.4, 0, 0]])
    first = compositor.frame(positions, rotations)
    second = compositor.frame(positions + shift, rotations)
    assert (second.ids == 0).sum() > 0.8 * (first.ids == 0).sum()
    before = first.rgb[first.ids == 0].mean(0)
    assert np.abs(second.rgb[second.ids == 0].mean(0) - before).max() < 8


def test_shadow_is_the_change_since_the_photo():
    scene = photographed(*ball((-0.4, 2.5, 0.2), 0.2), supports=[FLOOR])
    compositor = Compositor(scene)
    positions, rotations = initial_poses(scene)
    moved = compositor.frame(positions + np.array([0.8, 0, 0]), rotations)
    bare = compositor.frame(positions + np.array([0.8, 0, 0]), rotations, shadows=False)
    ground = moved.ids < 0
    darker = bare.rgb[..., 0].astype(int) - moved.rgb[..., 0]
    y, x = np.nonzero(ground & (darker > 15))
    assert len(y) > 20
    ball_x = np.nonzero(moved.ids == 0)[1].mean()
    assert abs(x.mean() - ball_x) < 25
    assert np.abs(darker[ground & (np.arange(SIZE[0]) < 40)]).max() == 0


def test_shadow_fades_with_height():
    item, mesh = ball((0.0, 2.5, 0.2), 0.2)
    scene = scene_of([item], {"ball": mesh}, [FLOOR])
    compositor = Compositor(scene)
    darkest = []
    for height in (0.2, 0.5, 1.0):
        frame = compositor.frame([[0, 2.5, height]], [[1, 0, 0, 0]])
        plain = compositor.frame([[0, 2.5, height]], [[1, 0, 0, 0]], shadows=False)
        change = plain.rgb.astype(int) - frame.rgb
        darkest.append(change[frame.ids < 0].max())
    assert darkest[0] > darkest[1] > darkest[2] > 3


def test_support_in_front_hides_what_falls_behind_it():
    support, support_mesh = table()
    item, mesh = crate((0.0, 3.0, 0.7), (0.3, 0.3, 0.4))
    scene = scene_of([item], {"crate": mesh}, [FLOOR, support], {"table": support_mesh})
    compositor = Compositor(scene)
    upright = [[1, 0, 0, 0]]
    on_top = (compositor.frame().ids == 0).sum()
    behind = compositor.frame([[0.0, 3.6, 0.2]], upright)
    half = compositor.frame([[0.0, 3.7, 0.45]], upright)
    front = compositor.frame([[0.0, 2.3, 0.2]], upright)
    assert on_top > 300
    assert (behind.ids == 0).sum() == 0
    assert np.isinf(behind.depth).all()
    assert 0 < (half.ids == 0).sum() < 0.8 * on_top
    assert (front.ids == 0).sum() > on_top
    empty = compositor.frame([[40, 3, 0]], upright, shadows=False)
    unshadowed = compositor.frame([[0.0, 3.6, 0.2]], upright, shadows=False)
    assert np.array_equal(unshadowed.rgb, empty.rgb)


def test_line_along_a_support_in_front_is_smooth():
    support, support_mesh = table()
    item, mesh = crate((0.1, 3.0, 0.7), (0.5, 0.3, 0.5))
    red = Mesh(mesh.vertices, mesh.faces, None, None, (250, 20, 20))
    scene = scene_of([item], {"crate": red}, [FLOOR, support], {"table": support_mesh})
    compositor = Compositor(scene)
    frame = compositor.frame([[0.45, 3.8, 0.45]], [[1, 0, 0, 0]], shadows=False)
    seen = frame.ids == 0
    line = seen[1:] != seen[:-1]
    assert seen.sum() > 200
    red_share = frame.rgb[..., 0].astype(int) - frame.rgb[..., 1]
    just_below = np.argwhere(line & seen[:-1]) + np.array([1, 0])
    values = red_share[just_below[:, 0], just_below[:, 1]]
    # Below the hard line some pixels are covered by the table in part only.
    assert ((values > 25) & (values < 150)).sum() > 5


def test_support_does_not_eat_into_what_stands_on_it():
    support, support_mesh = table()
    # Sunk by 2 cm, as an estimated pose may be.
    item, mesh = crate((0.0, 3.0, 0.68), (0.3, 0.3, 0.4))
    scene = photographed(item, mesh, [FLOOR, support], {"table": support_mesh})
    free = photographed(item, mesh, [FLOOR])
    mask = Compositor(free).frame().ids == 0
    shown = scene_of(
        [item],
        dict(scene.meshes),
        [FLOOR, support],
        {"table": support_mesh},
        photo=scene.photo,
        plate=scene.plate,
        masks={"crate": mask},
    )
    compositor = Compositor(shown)
    positions, rotations = initial_poses(shown)
    assert np.array_equal(compositor.frame().ids == 0, mask)
    # Fallen behind the table, it is hidden all the same.
    assert (compositor.frame([[0, 3.6, 0.2]], rotations).ids == 0).sum() == 0
    assert positions.shape == (1, 3)


def test_what_the_photo_shows_is_never_hidden():
    # A table estimated too far forward: it would hide a crate that the photo shows whole.
    support, support_mesh = table((0.0, 2.4, 0.4), (1.0, 0.4, 0.8))
    item, mesh = crate((0.0, 3.0, 0.2), (0.3, 0.3, 0.4))
    mask = Compositor(scene_of([item], {"crate": mesh}, [FLOOR])).frame().ids == 0
    scene = photographed(item, mesh, [FLOOR, support], {"table": support_mesh})
    scene = scene_of(
        [item],
        dict(scene.meshes),
        [FLOOR, support],
        {"table": support_mesh},
        photo=scene.photo,
        plate=scene.plate,
        masks={"crate": mask},
    )
    assert np.array_equal(Compositor(scene).frame().ids == 0, mask)


def test_nearer_object_covers_the_other():
    far, far_mesh = ball((0.0, 4.0, 0.25), name="far")
    near, near_mesh = crate((0.0, 2.5, 0.4), (0.8, 0.2, 0.8), name="near")
    scene = scene_of([far, near], {"far": far_mesh, "near": near_mesh}, [FLOOR])
    frame = Compositor(scene).frame()
    assert (frame.ids == 0).sum() == 0
    assert np.isfinite(frame.depth[frame.ids == 1]).all()
    assert abs(frame.depth[frame.ids == 1].min() - 2.4) < 0.4


def test_outline_is_blended():
    item, mesh = ball((0.0, 2.5, 0.6), 0.4, subdivisions=5)
    plate = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    anywhere = np.zeros((len(mesh.vertices), 2))
    white = Mesh(mesh.vertices, mesh.faces, anywhere, np.full((9, 9, 3), 255, np.uint8))
    scene = scene_of([item], {"ball": white}, [], plate=plate)
    red = Compositor(scene).frame().rgb[..., 0].astype(float)
    between = (red > 25) & (red < 230)
    assert between.sum() > 60
    # Nothing but the outline is mixed: one pixel wide.
    hard = Compositor(scene).frame().ids >= 0
    ring = cv2.morphologyEx(hard.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3))) > 0
    assert (between & ~ring).sum() == 0


def test_poses_out_of_the_picture_and_around_the_camera(two_things):
    compositor = Compositor(two_things)
    _, rotations = initial_poses(two_things)
    for place in ((40, 3, 0), (0, -3, 1), (0, 0, 1.2), (0, 0.1, 1.1), (0, 500, 0), (0, 3, -9)):
        frame = compositor.frame(np.array([place, place], float), rotations)
        assert frame.rgb.shape == (SIZE[1], SIZE[0], 3)
        assert np.array_equal(frame.ids >= 0, np.isfinite(frame.depth))


def test_bad_poses_are_refused(two_things):
    compositor = Compositor(two_things)
    positions, rotations = initial_poses(two_things)
    with pytest.raises(InputError, match="2 objects"):
        compositor.frame(positions[:1], rotations[:1])
    with pytest.raises(InputError, match="not finite"):
        compositor.frame(positions * np.nan, rotations)
    with pytest.raises(InputError, match="no object 'cup'"):
        compositor.frame(vertices={"cup": positions})
    with pytest.raises(InputError, match="'crate' has 8 vertices"):
        compositor.frame(vertices={"crate": positions})


def test_scene_without_objects():
    frame = Compositor(scene_of([], {}, [FLOOR])).frame()
    assert (frame.ids == -1).all()
    assert frame.rgb.std() > 1


def test_missing_mesh_is_named():
    item, _ = ball()
    with pytest.raises(InputError, match="'ball' has no mesh"):
        Compositor(scene_of([item], {}, [FLOOR]))


def test_objects_have_colours_of_their_own_and_light(two_things):
    frame = Compositor(two_things).frame()
    first, second = (frame.rgb[frame.ids == i].mean(0) for i in (0, 1))
    assert np.abs(first - second).max() > 60
    assert frame.rgb[frame.ids == 0].std(0).max() > 8


def test_same_bits_every_time(two_things):
    first, second = (Compositor(two_things).frame() for _ in range(2))
    assert np.array_equal(first.rgb, second.rgb)
    assert np.array_equal(first.depth, second.depth)


def test_shadows_in_a_thread_of_their_own_are_the_same_bits(monkeypatch):
    things = [ball((0.4 * n - 1, 3.0, 0.2), 0.15, f"b{n}", 2) for n in range(6)]
    scene = scene_of([o for o, _ in things], {o.name: m for o, m in things}, (FLOOR,))
    pictures = []
    for many in (1, 100):
        monkeypatch.setattr(compositor, "_MANY", many)
        pictures.append(Compositor(scene).frame().rgb)
    assert np.array_equal(*pictures)
    bare = Compositor(scene).frame(shadows=False).rgb
    assert (bare != pictures[0]).any(), "nothing casts a shadow"


def test_what_goes_wrong_with_the_shadows_is_raised(monkeypatch, two_things):
    monkeypatch.setattr(compositor, "_MANY", 1)
    made = Compositor(two_things)
    monkeypatch.setattr(Scenery, "behind", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        made.frame()


def spin(scene, frames=5):
    positions, _ = initial_poses(scene)
    count = len(positions)
    turned = [[about_axis((0, 0, 1), 0.1 * t)] * count for t in range(frames)]
    moved = np.repeat(positions[None], frames, 0)
    moved[:, :, 0] += np.linspace(0, 0.3, frames)[:, None]
    return rollout_of([o.name for o in scene.state.objects], moved, np.array(turned))


def test_clip_renders_each_frame_once(two_things):
    rollout = spin(two_things)
    told: list[float] = []
    clip = list(render_clip(two_things, rollout, progress=told.append))
    assert len(clip) == 5
    assert told == [0.2, 0.4, 0.6, 0.8, 1.0]
    (third,) = render_clip(two_things, rollout, [3])
    assert np.array_equal(third.rgb, clip[3].rgb)
    one = Compositor(two_things).frame(rollout.positions[3], rollout.rotations[3])
    assert np.array_equal(one.rgb, third.rgb)


def test_clip_can_be_cancelled(two_things):
    seen: list[float] = []
    clip = render_clip(
        two_things, spin(two_things), cancelled=lambda: len(seen) == 2, progress=seen.append
    )
    with pytest.raises(Cancelled):
        list(clip)
    assert len(seen) == 2


def test_clip_of_something_else_is_refused(two_things):
    rollout = spin(two_things)
    other = rollout_of(["a", "b"], rollout.positions, rollout.rotations)
    with pytest.raises(InputError, match="a, b"):
        render_clip(two_things, other)
    with pytest.raises(InputError, match="no frame 5"):
        render_clip(two_things, rollout, [5])


def test_clip_of_a_blown_up_run_stands_still(two_things):
    rollout = spin(two_things)
    rollout.positions[3:] = np.nan
    clip = list(render_clip(two_things, rollout))
    assert np.array_equal(clip[4].ids, clip[2].ids)


def test_mesh_of_many_pieces_and_flat_sheet():
    sheet = trimesh.Trimesh(
        [[-0.3, 0, 0], [0.3, 0, 0], [0.3, 0, 0.5], [-0.3, 0, 0.5]], [[0, 1, 2], [0, 2, 3]]
    )
    item, _ = crate((0.0, 2.5, 0.1), name="sheet")
    scene = scene_of([item], {"sheet": mesh_of(sheet)}, [FLOOR])
    compositor = Compositor(scene)
    front = compositor.frame()
    back = compositor.frame([(0.0, 2.5, 0.1)], [about_axis((0, 0, 1), np.pi)])
    assert (front.ids == 0).sum() == pytest.approx((back.ids == 0).sum(), abs=20)
    assert (front.ids == 0).sum() > 500
