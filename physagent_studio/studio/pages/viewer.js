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

  function prepare(state) {
    // A picture behind everything, as large as the canvas, which is never set; drawn all the same.
    if (state.backgroundMaterial) state.backgroundMaterial.visible = false;
    state.scene.onBeforeRender = () => window.studioDress?.(state.nodeRefFromName);
    if (!light) return;
    // viser takes news in at the beginning of a frame and draws that frame without them. Taken in
    // as they come they are in the next one; viser does so itself while its page is hidden.
    const ask = state.requestRender;
    state.requestRender = () => {
      moves();
      if (!state.firstMessageBatch && state.messageQueue.length && state.getRenderRequestState === "ready") state.drainMessageQueue?.();
      ask();
    };
    state.scene.onBeforeRender = (painter) => {
      const ratio = page * (moving ? LEVELS[level] : finest(state.canvas));
      if (painter.getPixelRatio() !== ratio) painter.setPixelRatio(ratio);
      solid(state.nodeRefFromName["/backdrop"]);
      window.studioDress?.(state.nodeRefFromName);
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
