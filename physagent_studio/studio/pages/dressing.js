// Runs in viser's own page before viewer.js, and in the page of a replay: the photo on what deforms.
//
// viser moves the vertices of plain meshes alone. The textured mesh of the same thing is in the
// scene too, hidden, with the same vertices in the same order; what moves puts on its texture.
window.studioDress = (nodes) => {
  const first = (node, fits) => {
    let found = null;
    node?.traverse((one) => { if (!found && one.isMesh && fits(one)) found = one; });
    return found;
  };
  for (const name in nodes) {
    if (!name.startsWith("/deforming/")) continue;
    const bare = first(nodes[name], (one) => !one.material.isShaderMaterial);
    const worn = first(nodes[`/objects/${name.split("/")[2]}`], (one) => one.material.map);
    const uv = worn?.geometry.attributes.uv, now = bare?.geometry.attributes;
    if (!uv || !now?.position || now.position.count !== uv.count) continue;
    if (now.uv !== uv) bare.geometry.setAttribute("uv", uv);
    if (bare.material !== worn.material) bare.material = worn.material;
  }
};
