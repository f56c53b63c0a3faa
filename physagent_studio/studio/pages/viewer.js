// Runs in viser's own page before viser does: what its client offers no setting for.
//
// Where a processor draws, because there is no graphics card or its driver is missing, every pixel
// counts: no smoothing of edges, no more pixels than the page has, no frame that shows what was
// already there. `?light` and `?full` in the address overrule what is found out.
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

  if (light) {
    HTMLCanvasElement.prototype.getContext = function (kind, wanted) {
      return makeContext.call(this, kind, kind === "webgl2" ? { ...wanted, antialias: false } : wanted);
    };
    const ratio = Math.min(1, window.devicePixelRatio);
    Object.defineProperty(window, "devicePixelRatio", { configurable: true, get: () => ratio });
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
    if (!light) return;
    // viser takes news in at the beginning of a frame and draws that frame without them. Taken in
    // as they come they are in the next one; viser does so itself while its page is hidden.
    const ask = state.requestRender;
    state.requestRender = () => {
      if (!state.firstMessageBatch && state.messageQueue.length && state.getRenderRequestState === "ready") state.drainMessageQueue?.();
      ask();
    };
  }
})();
