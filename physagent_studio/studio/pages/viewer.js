// Runs in viser's own page before viser does: what its client offers no setting for.
//
// Where a processor draws, because there is no graphics card or its driver is missing, every pixel
// counts: what moves is drawn coarsely, what rests finely, and no frame shows what was already
// there. `?light` and `?full` in the address overrule what is found out.
(() => {
  const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;
  const asked = new URLSearchParams(location.search);
  const makeContext = HTMLCanvasElement.prototype.getContext;

  function drawnBy() {
    const gl = makeContext.call(document.createElement("canvas"), "webgl2");
    const info = gl && gl.getExtension("WEBGL_debug_renderer_info");
    const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
    if (gl) gl.getExtension("WEBGL_lose_context")?.loseContext();
    return name;
  }

  const renderer = drawnBy();
  const light = asked.has("light") || (!asked.has("full") && SOFTWARE.test(renderer));
  window.studioDrawing = { renderer, light };

  // The server has the photographed sky taken away, but viser would develop it first: a second or
  // more without a graphics card, for a picture that nobody sees.
  const fetched = window.fetch;
  window.fetch = function (what, how) {
    const address = typeof what === "string" ? what : what?.url || "";
    return address.startsWith("data:image/jpeg") ? new Promise(() => {}) : fetched.call(this, what, how);
  };

  const page = Math.min(1, window.devicePixelRatio);
  if (light) {
    HTMLCanvasElement.prototype.getContext = function (kind, wanted) {
      return makeContext.call(this, kind, kind === "webgl2" ? { ...wanted, antialias: false } : wanted);
    };
    Object.defineProperty(window, "devicePixelRatio", { configurable: true, get: () => page });
  }

  // viser hands out its inner state here once its canvas is there.
  let inner;
  Object.defineProperty(window, "__viserMutable", {
    configurable: true,
    get: () => inner,
    set(state) { inner = state; prepare(state); },
  });

  // Things that one sees through; their own materials are kept to come back to.
  let glass = false;
  const solids = new Map();
  window.studioGlass = (on) => { glass = on; inner?.requestRender?.(); };

  function seeThrough(nodes) {
    if (!glass && !solids.size) return;
    for (const [name, node] of Object.entries(nodes)) {
      if (!name.startsWith("/objects/")) continue;
      node?.traverse?.((one) => {
        const material = one.isMesh && one.material;
        if (!material) return;
        if (glass && !solids.has(material)) {
          solids.set(material, [material.transparent, material.opacity, material.depthWrite]);
          [material.transparent, material.opacity, material.depthWrite] = [true, 0.4, false];
          material.needsUpdate = true;
        } else if (!glass && solids.has(material)) {
          [material.transparent, material.opacity, material.depthWrite] = solids.get(material);
          material.needsUpdate = true;
        }
      });
    }
    if (!glass) solids.clear();
  }

  // Whether all things, and the picture around them, have been taken in.
  window.studioDrawn = (names) => names.every((name) => {
    let found = false;
    inner?.nodeRefFromName[name]?.traverse?.((one) => { found ||= Boolean(one.isMesh); });
    return found;
  });

  // What is shown now as a picture of another size: drawn once into the same canvas.
  let drawnWith = null;
  window.studioPicture = (width, height) => new Promise((done, failed) => {
    if (!drawnWith) return failed(new Error("nothing is drawn yet"));
    const { painter, scene, camera } = drawnWith, ratio = painter.getPixelRatio(), aspect = camera.aspect;
    const size = { width: inner.canvas.clientWidth, height: inner.canvas.clientHeight };
    const hook = scene.onBeforeRender;
    scene.onBeforeRender = () => {};
    painter.setPixelRatio(1);
    painter.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    painter.render(scene, camera);
    const address = painter.domElement.toDataURL("image/png");
    scene.onBeforeRender = hook;
    camera.aspect = aspect;
    camera.updateProjectionMatrix();
    painter.setPixelRatio(ratio);
    painter.setSize(size.width, size.height, false);
    inner.requestRender?.();
    const bytes = Uint8Array.from(atob(address.split(",")[1]), (one) => one.charCodeAt(0));
    done(new Blob([bytes], { type: "image/png" }));
  });

  function each(painter, scene, camera, state) {
    drawnWith = { painter, scene, camera };
    seeThrough(state.nodeRefFromName);
    window.studioDress?.(state.nodeRefFromName);
  }

  function prepare(state) {
    // A picture behind everything, as large as the canvas, which is never set; drawn all the same.
    if (state.backgroundMaterial) state.backgroundMaterial.visible = false;
    state.scene.onBeforeRender = (painter, scene, camera) => each(painter, scene, camera, state);
    if (!light) return;
    // viser takes news in at the beginning of a frame and draws that frame without them. Taken in
    // as they come they are in the next one; viser does so itself while its page is hidden.
    const ask = state.requestRender;
    state.requestRender = () => {
      moves();
      if (!state.firstMessageBatch && state.messageQueue.length && state.getRenderRequestState === "ready") state.drainMessageQueue?.();
      ask();
    };
    state.scene.onBeforeRender = (painter, scene, camera) => {
      const ratio = page * (moving ? LEVELS[level] : finest(state.canvas));
      if (painter.getPixelRatio() !== ratio) painter.setPixelRatio(ratio);
      solid(state.nodeRefFromName["/backdrop"]);
      each(painter, scene, camera, state);
    };
  }

  // The photo behind everything is most of the pixels. It hides what is behind it, which viser
  // cannot know, and one size of it is enough for each pixel rather than a blend of two.
  const ONE_SIZE = 1007; // three.js: LinearMipmapNearestFilter
  function solid(photo) {
    photo?.traverse(({ isMesh, material }) => {
      if (!isMesh || !material.map || !material.transparent) return;
      material.transparent = false;
      material.map.minFilter = ONE_SIZE;
      material.needsUpdate = material.map.needsUpdate = true;
    });
  }

  // Pixels of the canvas for one of the page: in motion as many as the pace allows; finer than the
  // page in the next of the frames that viser draws once a second at rest, which smooths edges
  // better than the setting that was left out above.
  const FINE = 1.5, MOST = 1.6e6, REST = 400, SLOW = 50, FAST = 25, LEVELS = [1, 0.8, 0.65];
  let level = 0, moving = 0, last = 0, pace = [];

  const finest = ({ clientWidth: wide, clientHeight: high }) => Math.max(1, Math.min(FINE, Math.sqrt(MOST / Math.max(1, wide * high))));

  function moves() {
    if (!moving) requestAnimationFrame(beat);
    clearTimeout(moving);
    moving = setTimeout(() => { moving = 0; }, REST);
  }

  // While something moves every beat is a frame; a dozen of them say whether the pace is kept.
  function beat(now) {
    if (!moving) { last = 0; pace = []; return; }
    if (last) pace.push(now - last);
    last = now;
    if (pace.length === 12) {
      const middle = pace.sort((a, b) => a - b)[6];
      pace = [];
      if (middle > SLOW) level = Math.min(LEVELS.length - 1, level + 1);
      else if (middle < FAST) level = Math.max(0, level - 1);
    }
    requestAnimationFrame(beat);
  }
})();
