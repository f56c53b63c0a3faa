"""The picture behind the objects: the photo while they stand, its sun, its shadows."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from physagent_studio.records.scene import Mesh
from physagent_studio.rendering import Compositor
from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.compositor import initial_poses, lens_of
from physagent_studio.rendering.contact import contact_light
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.grid import enlarged
from physagent_studio.rendering.mirror import Mirror
from physagent_studio.rendering.settled import _reasons
from physagent_studio.rendering.shadow import Lamp, Shadows
from physagent_studio.rendering.stage import Stage
from physagent_studio.rendering.sun import CONTACT, DEFAULT, Shading, usual_light
from tests.rendering.scenes import FLOOR, SIZE, ball, crate, scene_of, table


def things():
    first, first_mesh = ball((-0.35, 2.4, 0.2), 0.2)
    second, second_mesh = crate((0.45, 2.7, 0.25), (0.3, 0.3, 0.5))
    return [first, second], {"ball": first_mesh, "crate": second_mesh}


def floor_picture(seed: int = 2) -> Picture:
    """An evenly lit floor with fine texture and a gradient."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    tone = 150 + 0.12 * y + 0.05 * x + rng.normal(0, 2.5, (SIZE[1], SIZE[0]))
    return np.clip(tone[..., None] * (1.0, 0.95, 0.85), 0, 255).astype(np.uint8)


def sunlit(direction, strength=0.5, patch=None):
    """A scene whose photo has shadows from a known lamp, and the true floor without any."""
    objects, meshes = things()
    bare = scene_of(objects, meshes, [FLOOR])
    camera = bare.state.camera
    assert camera is not None
    batch = Batch.of(list(meshes.values()))
    world = batch.placed(*initial_poses(bare))
    ground = Stage.of(bare.state, {}, camera, lens_of(camera)).ground
    floor = floor_picture()
    if patch is not None:
        cv2.ellipse(floor, patch, (60, 55, 50), -1)
    photo = floor
    if direction is not None:
        lamp = Lamp(np.array(direction) / np.linalg.norm(direction), 0.1, 6.0)
        blocked = Shadows.of(batch, ground, lamp).blocked(world, np.ones(2))
        light = 1 - strength * enlarged(blocked, ground.step, floor.shape)
        photo = (floor * light[..., None]).astype(np.uint8)
    frame = Compositor(bare).frame()
    hole = cv2.dilate((frame.ids >= 0).astype(np.uint8), np.ones((5, 5))) > 0
    photo = np.where((frame.ids >= 0)[..., None], frame.rgb, photo)
    masks = {item.name: frame.ids == i for i, item in enumerate(objects)}
    painted = {
        name: Mesh(m.vertices, m.faces, camera.project(world[batch.owner == i])[0], photo)
        for i, (name, m) in enumerate(meshes.items())
    }
    scene = scene_of(objects, painted, [FLOOR], photo=photo, plate=floor, masks=masks)
    return scene, floor, hole


@pytest.mark.parametrize("direction", [(-1.0, 0.1, 0.7), (0.6, -0.6, 0.6), (0.3, 0.8, 0.9)])
def test_the_sun_is_read_off_the_photo(direction):
    scene, _, _ = sunlit(direction)
    scenery = Compositor(scene)._scenery
    assert scenery.sun.seen
    truth = np.arctan2(direction[1], direction[0])
    found = np.arctan2(scenery.sun.lamp.direction[1], scenery.sun.lamp.direction[0])
    assert abs((found - truth + np.pi) % (2 * np.pi) - np.pi) < np.radians(3)
    assert 0.25 < scenery.sun.strength.mean() < 0.7


def test_without_shadows_no_sun_is_seen():
    scene, _, _ = sunlit(None)
    assert Compositor(scene)._scenery.sun is DEFAULT


def test_the_sun_is_read_off_uneven_ground_too():
    scene, floor, _ = sunlit((-1.0, 0.1, 0.7))
    assert scene.photo is not None
    noise = np.random.default_rng(0).normal(0, 1, (SIZE[1] // 4, SIZE[0] // 4)).astype(np.float32)
    blotched = np.exp(0.55 * cv2.resize(noise, SIZE, interpolation=cv2.INTER_CUBIC))[..., None]
    photo, plate = (
        (one * blotched * 0.4).clip(0, 255).astype(np.uint8) for one in (scene.photo, floor)
    )
    sun = Compositor(replace(scene, photo=photo, plate=plate))._scenery.sun
    assert sun.seen
    assert sun.lamp.direction[0] < -0.6
    assert 0.3 < sun.strength.mean() < 0.7


def shade_beside(size, above=0.0):
    """How much sky a box keeps from the ground right before it."""
    item, mesh = crate((0.0, 2.6, size[2] / 2 + above), size)
    scene = scene_of([item], {"crate": mesh}, [FLOOR])
    camera = scene.state.camera
    assert camera is not None
    batch = Batch.of([mesh])
    ground = Stage.of(scene.state, {}, camera, lens_of(camera)).ground
    blocked = Shadows.of(batch, ground, CONTACT.lamp).blocked(
        batch.placed(*initial_poses(scene)), np.ones(1)
    )
    x, y, z = np.moveaxis(ground.points, -1, 0)
    near = (np.abs(x) < 0.1) & (y < 2.6 - size[1] / 2 - 0.02) & (y > 2.6 - size[1] / 2 - 0.09)
    assert near.sum() >= 5
    assert np.isfinite(z[near]).all()
    return float(blocked[near].mean())


def test_what_stands_keeps_sky_from_the_ground_beside_it_the_more_the_higher_it_is():
    low, high = shade_beside((0.5, 0.4, 0.02)), shade_beside((0.5, 0.4, 0.5))
    assert high > max(0.15, 1.5 * low)


def test_shade_fades_as_its_thing_rises():
    each = [shade_beside((0.5, 0.4, 0.5), above) for above in (0.0, 0.15, 0.4, 0.9)]
    assert each == sorted(each, reverse=True)
    assert each[1] > 0.6 * each[0]
    assert each[3] < 0.2 * each[0]


def test_a_dark_patch_that_the_plate_has_too_is_no_shadow():
    scene, _, _ = sunlit(None, patch=((150, 100), (60, 22), 0))
    assert not Compositor(scene)._scenery.sun.seen


def test_new_shadows_fall_as_the_photo_has_them():
    scene, _, _ = sunlit((-1.0, 0.1, 0.7))
    compositor = Compositor(scene)
    positions, rotations = initial_poses(scene)
    moved = positions + np.array([[0.1, 0.1, 0.0], [0, 0, 0]])
    frame = compositor.frame(moved, rotations)
    bare = compositor.frame(moved, rotations, shadows=False)
    darker = (bare.rgb.astype(int) - frame.rgb).sum(-1) * (frame.ids < 0)
    _, x = np.nonzero(darker > 30)
    assert len(x) > 100
    # The sun stands on the left, so the shadow reaches to the right.
    assert x.mean() > np.nonzero(frame.ids == 0)[1].mean() + 4


def test_first_frame_is_the_photo_everywhere():
    scene, _, _ = sunlit((-1.0, 0.1, 0.7))
    assert scene.photo is not None
    assert np.abs(Compositor(scene).frame().rgb.astype(int) - scene.photo).max() <= 1


def test_what_stands_still_keeps_its_place_in_the_photo():
    scene, _, _ = sunlit((-1.0, 0.1, 0.7))
    assert scene.photo is not None
    compositor = Compositor(scene)
    positions, rotations = initial_poses(scene)
    away = positions + np.array([[-3.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    frame = compositor.frame(away, rotations)
    near_crate = cv2.dilate(scene.masks["crate"].astype(np.uint8), np.ones((7, 7))) > 0
    assert np.abs(frame.rgb.astype(int) - scene.photo)[near_crate].max() <= 1
    left = scene.masks["ball"]
    assert np.abs(frame.rgb.astype(int) - scene.photo)[left].mean() > 15


def test_as_built_shows_what_the_reconstruction_made():
    scene, _, _ = sunlit((-1.0, 0.1, 0.7))
    too_large = dict(scene.meshes)
    mesh = too_large["ball"]
    too_large["ball"] = Mesh(mesh.vertices * 1.4, mesh.faces, mesh.uv, mesh.texture)
    wrong = scene_of(
        scene.state.objects,
        too_large,
        [FLOOR],
        photo=scene.photo,
        plate=scene.plate,
        masks=dict(scene.masks),
    )
    compositor = Compositor(wrong)
    beside = (compositor.frame().ids == 0) & ~scene.masks["ball"]
    assert beside.sum() > 100
    assert scene.photo is not None
    kept, built = compositor.frame(), compositor.frame(as_built=True)
    assert np.abs(kept.rgb.astype(int) - scene.photo)[beside].max() <= 1
    assert np.abs(built.rgb.astype(int) - scene.photo)[beside].mean() > 20


def under_the(lamp):
    """Two things on their ground and what they keep of a lamp from it: the batch, the ground, the
    vertices (V, 3) in the world and the share (h, w) that is blocked."""
    scene, _, _ = sunlit(None)
    camera = scene.state.camera
    assert camera is not None
    batch = Batch.of([scene.meshes[o.name] for o in scene.state.objects])
    ground = Stage.of(scene.state, {}, camera, lens_of(camera)).ground
    world = batch.placed(*initial_poses(scene))
    return batch, ground, world, Shadows.of(batch, ground, lamp).blocked(world, np.ones(2))


@pytest.mark.parametrize("dark", [0.0, 0.25, 0.6])
def test_the_shade_at_a_foot_is_as_dark_as_the_photo_shows_it(dark: float):
    batch, ground, world, blocked = under_the(CONTACT.lamp)
    seen = np.repeat(np.log(1 - dark * blocked)[..., None], 3, 2).astype(np.float32)
    everywhere = np.ones(ground.shape, bool)
    shading = Shading(seen, everywhere, everywhere, np.ones(3))
    free = np.ones(SIZE[::-1], bool)
    rough = np.random.default_rng(2).integers(60, 220, (SIZE[1] // 16, SIZE[0] // 16, 3), np.uint8)
    uneven = np.asarray(cv2.resize(rough, SIZE, interpolation=cv2.INTER_NEAREST), np.uint8)
    found = contact_light(shading, DEFAULT, uneven, free, batch, world, ground).strength
    assert found == pytest.approx(np.full(3, max(dark, 0.1)), abs=0.05)
    assert contact_light(None, DEFAULT, uneven, free, batch, world, ground) is CONTACT


@pytest.mark.parametrize("dark", [0.0, 0.5])
@pytest.mark.parametrize("slope", [0.0, 40.0])
def test_even_ground_tells_of_the_shade_at_a_foot_where_the_plate_does_not(dark, slope):
    batch, ground, world, blocked = under_the(CONTACT.lamp)
    shade = enlarged((1 - dark * blocked)[..., None].astype(np.float32), ground.step, SIZE[::-1])
    # Brighter to one side, as towards a window.
    floor = 160 + slope * np.linspace(-1, 1, SIZE[0])[None, :, None] * np.ones((SIZE[1], 1, 3))
    photo = (floor * shade.reshape(*SIZE[::-1], 1)).astype(np.uint8)
    free = np.ones(SIZE[::-1], bool)
    found = contact_light(None, DEFAULT, photo, free, batch, world, ground).strength
    assert found == pytest.approx(np.full(3, max(dark, 0.1)), abs=0.08)


def test_shade_that_the_photo_does_not_show_has_the_colour_of_its_ground():
    scene, _, _ = sunlit(None)
    assert scene.plate is not None
    wood = (scene.plate * np.array([1.0, 0.75, 0.5])).astype(np.uint8)
    compositor = Compositor(replace(scene, photo=wood, plate=wood))
    place, turned = initial_poses(scene)
    shaded = compositor.frame(place + np.array([0.9, 0.3, 0.0]), turned)
    light = shaded.rgb.astype(float) / compositor.frame(place + np.array([9.0, 0, 0]), turned).rgb
    at = (light.max(-1) < 0.85) & (shaded.ids < 0)
    assert at.sum() > 30
    red, green, blue = light[at].mean(0)
    assert blue < green - 0.04 < red - 0.08


def test_a_shadow_stays_while_its_thing_stands_though_another_leaves_from_nearer():
    """The crate's shadow falls where the ball is nearer than the crate."""
    scene, floor, _ = sunlit((1.0, 0.25, 0.45))
    assert scene.photo is not None
    compositor = Compositor(scene)
    assert compositor._scenery.sun.seen
    positions, rotations = initial_poses(scene)
    away = positions + np.array([[-9.0, 0, 0], [0, 0, 0]])
    frame = compositor.frame(away, rotations)
    dark = (floor.astype(int) - scene.photo).mean(-1) > 30
    between = dark[:, 96:116] & (frame.ids < 0)[:, 96:116]
    assert between.sum() > 40
    kept = (floor.astype(int) - frame.rgb).mean(-1)[:, 96:116][between]
    assert kept.mean() > 0.7 * (floor.astype(int) - scene.photo).mean(-1)[:, 96:116][between].mean()


def test_a_shadow_of_the_photo_gives_way_little_by_little():
    scene, floor, hole = sunlit((-1.0, 0.1, 0.7))
    compositor = Compositor(scene)
    positions, rotations = initial_poses(scene)
    assert scene.photo is not None
    shadow = (np.abs(scene.photo.astype(int) - floor).mean(-1) > 15) & ~hole
    shadow &= cv2.dilate(hole.astype(np.uint8), np.ones((41, 41))) == 0
    assert shadow.sum() > 100
    away = np.linspace(0, 0.3, 31)[:, None] * np.array([1.0, 0, 0])
    frames = [compositor.frame(positions + step, rotations, shadows=False) for step in away]
    tones = np.array([frame.rgb[shadow].mean() for frame in frames])
    assert tones[0] < floor[shadow].mean() - 15
    assert np.abs(np.diff(tones)).max() < 0.15 * (floor[shadow].mean() - tones[0])


def test_nothing_is_shaded_by_light_that_does_not_fall_there():
    support, top = table((0.0, 3.0, 0.25), (1.0, 0.8, 0.5))
    item, mesh = ball((0.0, 2.6, 0.75), 0.25)
    scene = scene_of([item], {"ball": mesh}, [FLOOR, support], {"table": top})
    camera = scene.state.camera
    assert camera is not None
    batch = Batch.of([mesh])
    ground = Stage.of(scene.state, scene.support_meshes, camera, lens_of(camera)).ground
    world = batch.placed(*initial_poses(scene))
    blocked = Shadows.of(batch, ground, CONTACT.lamp).blocked(world, np.ones(1))
    x, y, z = np.moveaxis(ground.points, -1, 0)
    near = np.abs(x) < 0.1
    front = near & (np.abs(y - 2.6) < 1e-3) & (z < 0.45)
    assert front.sum() > 10
    assert blocked[near & (np.abs(z - 0.5) < 1e-3)].max() > 0.3
    assert blocked[front].max() < 1e-6


def test_a_shadow_that_two_cast_is_kept_for_the_nearer():
    shape = (40, 60)
    masks = [np.zeros(shape, bool) for _ in range(2)]
    masks[0][5:10, 10:20] = True
    masks[1][20:30, 10:20] = True
    shadow = np.zeros(shape, bool)
    shadow[22:30, 20:50] = True
    assert (_reasons([*masks], [shadow, shadow], shape)[shadow] == 1).all()
    nowhere = np.zeros(shape, bool)
    far = shadow & (np.arange(60) > 30)
    assert (_reasons([*masks], [shadow, nowhere], shape)[far] == 0).all()


def polished(strength):
    """A ball and a crate on ground that shows them upside down, and a plate that does not."""
    scene, floor, _ = sunlit(None)
    shown = replace(scene, photo=floor, plate=floor)
    compositor = Compositor(shown)
    place, turned = initial_poses(scene)
    mirror = Mirror(compositor._skin, compositor._stage.ground, 0.0, strength)
    world = compositor._batch.placed(place, turned)
    photo = mirror.drawn(floor, world, turned, False, np.ones(2))
    things = compositor.frame(as_built=True, shadows=False)
    photo = np.where((things.ids >= 0)[..., None], things.rgb, photo)
    return replace(scene, photo=photo, plate=floor)


def test_polished_ground_shows_what_moves():
    compositor = Compositor(polished(0.4))
    assert compositor._mirror is not None
    assert compositor._mirror.strength == pytest.approx(0.4, abs=0.08)
    place, turned = initial_poses(polished(0.4))
    still = compositor.frame()
    gone = compositor.frame(place + np.array([[9.0, 0, 0], [0, 0, 0]]), turned)
    moved = compositor.frame(place + np.array([[0.0, -0.25, 0], [0, 0, 0]]), turned)
    assert np.abs(still.rgb.astype(int) - polished(0.4).photo).max() <= 1
    rows, columns = np.nonzero(moved.ids == 0)
    below = np.zeros(moved.ids.shape, bool)
    below[rows.max() + 4 : rows.max() + 12, int(columns.mean()) - 3 : int(columns.mean()) + 4] = (
        True
    )
    lost = np.abs(moved.rgb.astype(int) - gone.rgb).mean(-1)
    assert lost[below].mean() > 8


def test_dull_ground_shows_nothing():
    assert Compositor(polished(0.0))._mirror is None
    scene, _, _ = sunlit((-1.0, 0.1, 0.7))
    assert Compositor(scene)._mirror is None


@pytest.mark.parametrize("pattern", [0.0, 0.3, 0.6])
def test_soft_shade_where_a_mirror_image_would_be_is_none(pattern: float):
    """Under a dark thing the ground gets darker towards it, as its mirror image would be.

    pattern: by how much less light the dark parts of the ground throw back.
    """
    scene = polished(0.5)
    assert scene.plate is not None
    assert scene.photo is not None
    floor = scene.plate.astype(np.float32)
    deeper = np.maximum(floor - scene.photo, 0).mean(-1) / floor.mean(-1)
    shade = cv2.GaussianBlur(deeper, (0, 0), 9)[..., None]
    things = (Compositor(scene).frame().ids >= 0)[..., None]
    squares = np.random.default_rng(1).random((60, 104)).astype(np.float32) * pattern
    ground = floor * (1 - cv2.resize(squares, SIZE, interpolation=cv2.INTER_LINEAR))[..., None]
    photo = np.where(things, scene.photo, (ground * (1 - shade)).astype(np.uint8))
    shaded = replace(scene, photo=photo, plate=ground.astype(np.uint8))
    assert Compositor(shaded)._mirror is None


def test_shade_on_patterned_ground_is_no_mirror_image_of_a_black_thing():
    """Both keep some of the ground's light from it, and show its pattern."""
    scene = polished(0.5)
    assert scene.plate is not None
    black = {n: Mesh(m.vertices, m.faces, None, None, (9, 9, 9)) for n, m in scene.meshes.items()}
    squares = np.random.default_rng(1).random((60, 104)).astype(np.float32)
    pattern = 1 - 0.6 * cv2.resize(squares, SIZE, interpolation=cv2.INTER_LINEAR)[..., None]
    plate = (scene.plate * pattern).astype(np.uint8)
    things = Compositor(scene).frame().ids >= 0
    away = cv2.distanceTransform((~things).astype(np.uint8), cv2.DIST_L2, 5)
    shade = 0.5 * np.exp(-np.maximum(away, 0) / 25)[..., None]
    photo = np.where(things[..., None], 9, plate * (1 - shade)).astype(np.uint8)
    shaded = replace(scene, photo=photo, plate=plate, meshes=black)
    assert Compositor(shaded)._mirror is None


def test_a_shadow_has_the_colour_of_its_ground_and_not_of_what_shines_into_it():
    scene, _, _ = sunlit((-1.0, 0.1, 0.7))
    assert scene.plate is not None
    assert scene.photo is not None
    things = (Compositor(scene).frame().ids >= 0)[..., None]
    plate = scene.plate.astype(float)
    # Something red shines into the shadow on grey ground.
    glowing = (scene.photo / plate) ** np.array([0.4, 1.0, 1.0])
    photo = np.where(things, scene.photo, np.clip(plate * glowing, 0, 255).astype(np.uint8))
    sun = Compositor(replace(scene, photo=photo))._scenery.sun
    assert sun.seen
    depth = -np.log(1 - sun.strength)
    assert depth.max() / depth.min() < 1.6


@pytest.mark.parametrize("strength", [0.0, 0.35])
def test_the_usual_light_is_as_weak_as_even_ground_shows_it(strength: float):
    batch, ground, world, blocked = under_the(DEFAULT.lamp)
    floor = np.full((SIZE[1], SIZE[0], 3), 220, np.uint8)
    shade = enlarged(
        (1 - strength * blocked)[..., None].astype(np.float32), ground.step, SIZE[::-1]
    )
    photo = (floor * shade.reshape(*SIZE[::-1], 1)).astype(np.uint8)
    free = np.ones(SIZE[::-1], bool)
    found = usual_light(photo, free, batch, world, ground)
    assert found.strength == pytest.approx(np.full(3, max(strength, 0.12)), abs=0.06)
    # Uneven ground does not tell.
    rough = np.random.default_rng(2).integers(60, 220, (SIZE[1] // 16, SIZE[0] // 16, 3), np.uint8)
    rough = cv2.resize(rough, SIZE, interpolation=cv2.INTER_NEAREST)
    assert usual_light(np.asarray(rough, np.uint8), free, batch, world, ground) is DEFAULT
