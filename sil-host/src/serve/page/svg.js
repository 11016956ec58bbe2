// Shapes as text of SVG, and numbers and times as people write them.

/** Text fit for SVG. */
export const escaped = (text) => String(text).replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);

/** A shape of a class, with its attributes (numbers to a tenth) and what is in it, fit for SVG. */
export function shape(name, as, attributes, inside = "") {
  const value = (of) => (typeof of === "number" ? Number(of.toFixed(1)) : of);
  const all = Object.entries(attributes).map(([key, of]) => `${key}="${value(of)}"`);
  return `<${name} class="${as}" ${all.join(" ")}>${inside}</${name}>`;
}

/** A line of these points; a gap where there is none. */
export function path(points) {
  let text = "";
  let drawing = false;
  for (const point of points) {
    if (point) text += `${drawing ? "L" : "M"}${point[0].toFixed(1)} ${point[1].toFixed(1)}`;
    drawing = Boolean(point);
  }
  return text;
}

/** Words at a place. */
export const words = (as, x, y, text, anchor = "start") =>
  shape("text", as, { x, y, "text-anchor": anchor }, escaped(text));

/** Seconds as h:mm:ss. */
export function clock(seconds) {
  const two = (n) => String(n).padStart(2, "0");
  return `${Math.floor(seconds / 3600)}:${two(Math.floor(seconds / 60) % 60)}:${two(seconds % 60)}`;
}

/** A number with three significant digits. */
export function short(value) {
  if (value === null || value === undefined) return "–";
  const size = Math.abs(value);
  if (size >= 1000) return Math.round(value).toLocaleString("en").replace("-", "−");
  const digits = size >= 100 ? 0 : size >= 10 ? 1 : size >= 0.1 ? 2 : size > 0 ? 3 : 0;
  return value.toFixed(digits).replace("-", "−");
}
