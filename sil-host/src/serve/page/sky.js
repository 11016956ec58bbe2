// The map of the whole sky, as text of SVG, and the Earth's disc behind it.
//
// In: a second looked at (/api/second); directions are unit vectors in ICRS axes. Hammer's projection, right
// ascension 180 deg in the middle, growing to the left. Drawings only.

import { shape, words } from "/svg.js";

/** Half width and height of the map, and its middle, in its viewBox. */
const HALF = [176, 86];
const MIDDLE = [180, 90];
const [SKY, EARTH] = [
  [10, 16, 32, 255],
  [46, 92, 140, 255],
];
const RAD = Math.PI / 180;

/** Where a direction is on the map. */
function onSky([x, y, z]) {
  const longitude = Math.atan2(-y, -x);
  const cosine = Math.hypot(x, y);
  const root = Math.sqrt(1 + cosine * Math.cos(longitude / 2));
  return [
    MIDDLE[0] - (HALF[0] * cosine * Math.sin(longitude / 2)) / root,
    MIDDLE[1] - (HALF[1] * z) / root,
  ];
}

/** The direction at a place of the map; null outside of it. */
function ofSky(px, py) {
  const x = ((MIDDLE[0] - px) / HALF[0]) * 2 * Math.SQRT2;
  const y = ((MIDDLE[1] - py) / HALF[1]) * Math.SQRT2;
  const square = 1 - (x / 4) ** 2 - (y / 2) ** 2;
  if (square < 0.5) return null;
  const root = Math.sqrt(square);
  const longitude = 2 * Math.atan2(root * x, 2 * (2 * square - 1));
  const cosine = Math.sqrt(Math.max(0, 1 - (root * y) ** 2));
  return [-cosine * Math.cos(longitude), -cosine * Math.sin(longitude), root * y];
}

/** A line over the sky, broken where it leaves the map's edge and comes in at the other. */
function line(as, directions, closed) {
  const points = directions.map(onSky);
  if (closed) points.push(...points.slice(0, 1));
  const far = (k) => k === 0 || Math.abs(points[k][0] - points[k - 1][0]) > HALF[0] / 2;
  const d = points.map(([x, y], k) => `${far(k) ? "M" : "L"}${x.toFixed(1)} ${y.toFixed(1)}`);
  return shape("path", as, { d: d.join("") });
}

/** A disc with its name; without a radius the name only. */
function mark(as, direction, radius, name) {
  const [x, y] = onSky(direction);
  const left = x > 300;
  const disc = radius ? shape("circle", as, { cx: x, cy: y, r: radius }) : "";
  const beside = radius + 3;
  return disc + words("name", left ? x - beside : x + beside, y + 3.5, name, left ? "end" : "start");
}

const directions = [];

/** The Earth's disc, by the direction of every pixel: it may hold a pole or the map's edge. */
export function earthDisc(canvas, { sky: { earth, limb } }) {
  const { width, height } = canvas;
  for (let k = directions.length; k < width * height; k++) {
    directions.push(
      ofSky((((k % width) + 0.5) * 360) / width, ((Math.floor(k / width) + 0.5) * 180) / height),
    );
  }
  const context = canvas.getContext("2d");
  const picture = context.createImageData(width, height);
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const edge = limb.reduce((sum, point) => sum + dot(point, earth), 0) / limb.length;
  directions.forEach((direction, k) => {
    if (direction) picture.data.set(dot(direction, earth) > edge ? EARTH : SKY, 4 * k);
  });
  context.putImageData(picture, 0, 0);
}

let behind = "";

/** Grid and stars, which stay. */
function background(stars) {
  const arc = (of) => Array.from({ length: 73 }, (_, k) => of(k / 72));
  const at = (ra, dec) => {
    const [a, d] = [ra * RAD, dec * RAD];
    return [Math.cos(d) * Math.cos(a), Math.cos(d) * Math.sin(a), Math.sin(d)];
  };
  let text = "";
  for (let ra = 30; ra < 360; ra += 30)
    text += line(
      "grid",
      arc((part) => at(ra, 180 * part - 90)),
    );
  for (let dec = -60; dec <= 60; dec += 30)
    text += line(
      "grid",
      arc((part) => at(0.001 + 359.998 * part, dec)),
    );
  text += shape("ellipse", "edge", { cx: MIDDLE[0], cy: MIDDLE[1], rx: HALF[0], ry: HALF[1] });
  for (const [x, y, z, v] of stars) {
    const [cx, cy] = onSky([x, y, z]);
    text += shape("circle", "back", { cx, cy, r: (0.35 + 0.24 * (4.2 - v)).toFixed(2) });
  }
  return text;
}

/** The map; `stars` are those of its background: direction and V; `body` is what is flown about. */
export function sky(svg, look, stars, body) {
  behind ||= background(stars);
  const { field, earth_field, sun, neighbour, earth, boresight } = look.sky;
  let text = behind + line("earth-field", earth_field, true) + line("field", field, true);
  for (const { direction } of look.stars.filter((star) => star.direction)) {
    const [cx, cy] = onSky(direction);
    text += shape("circle", "used", { cx, cy, r: 1.3 });
  }
  text += mark("earth", earth, 0, body.name) + mark("sun", sun, 4.5, "Sun");
  if (neighbour) text += mark("moon", neighbour, 3, body.neighbour);
  const [x, y] = onSky(boresight).map((part) => part.toFixed(1));
  text += shape("path", "boresight", { d: `M${x} ${y}m-4 0h8m-4 -4v8` });
  svg.innerHTML = text;
}
