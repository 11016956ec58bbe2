// What was found in the frame, drawn over it, as text of SVG in the detector's pixels.

import { shape, words } from "/svg.js";

/** Most stars that have their Hipparcos number beside them. */
const LABELS = 12;

/** What was found in the frame, in the detector's pixels. */
export function overlay(svg, look, shown) {
  const [width, height] = look.size_px ?? [1280, 1024];
  svg.setAttribute("viewBox", `-0.5 -0.5 ${width} ${height}`);
  let text = "";
  for (const [x, y, w, h] of (shown.windows && look.windows) || []) {
    text += shape("rect", "window", { x, y, width: w, height: h });
  }
  if (shown.limb && look.limb_path) text += shape("path", "limb", { d: look.limb_path });
  for (const [cx, cy] of shown.limb ? look.limb_px : []) {
    text += shape("circle", "limb-point", { cx, cy, r: 5 });
  }
  (shown.stars ? look.stars : []).forEach(({ hip, v, residual_px, at_px: [cx, cy] }, number) => {
    const title = `<title>HIP ${hip}, V ${v ?? "?"}, ${residual_px} px off</title>`;
    text += shape("circle", "star", { cx, cy, r: 16 }, title);
    const left = cx > width - 150;
    if (number < LABELS)
      text += words("hip", left ? cx - 22 : cx + 22, cy + 9, hip, left ? "end" : "start");
  });
  svg.innerHTML = text;
}
