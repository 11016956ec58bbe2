// The globe from above the satellite's place, as text of SVG.
//
// In: a second looked at (/api/second), the ground track, coasts; places are degrees of latitude and longitude.
// Orthographic. Drawings only.

import { path, shape, words } from "/svg.js";

/** Middle and radius in the viewBox. */
const CENTRE = [98, 92];
const RADIUS = 88;
const RAD = Math.PI / 180;
/** Steps of half the rim. */
const RIM = 48;
const KEYS = {
  sat: "satellite",
  track: "ground track",
  lit: "limb in view, lit",
  dark: "limb in view, dark",
  outside: "limb not in view",
  sun: "Sun at the zenith",
};

/** The globe as seen from above a place: gives [x, y, depth] of latitude and longitude. */
function from(latitude, longitude) {
  const [s0, c0] = [Math.sin(latitude * RAD), Math.cos(latitude * RAD)];
  return ([lat, lon]) => {
    const [s, c, turn] = [Math.sin(lat * RAD), Math.cos(lat * RAD), (lon - longitude) * RAD];
    const x = CENTRE[0] + RADIUS * c * Math.sin(turn);
    const y = CENTRE[1] - RADIUS * (c0 * s - s0 * c * Math.cos(turn));
    return [x, y, s0 * s + c0 * c * Math.cos(turn)];
  };
}

/** The night side: from the terminator back along the rim. */
function night(sun, view) {
  const [x, y, depth] = view(sun);
  const heading = Math.atan2(CENTRE[1] - y, x - CENTRE[0]);
  const [s, c] = [Math.sin(heading), Math.cos(heading)];
  const half = Array.from({ length: RIM + 1 }, (_, k) => Math.PI * (k / RIM - 0.5));
  const at = (along, across) => [
    CENTRE[0] + RADIUS * (along * c - across * s),
    CENTRE[1] - RADIUS * (along * s + across * c),
  ];
  const terminator = half.map((angle) => at(-depth * Math.cos(angle), Math.sin(angle)));
  const rim = half.reverse().map((angle) => at(-Math.cos(angle), Math.sin(angle)));
  return shape("path", "night", { d: `${path([...terminator, ...rim])}Z` });
}

/** Draws the globe; `track` are places of the run so far. */
export function globe(svg, look, coast, track) {
  const { below_deg, sun_deg, limb } = look.globe;
  const view = from(0.6 * below_deg[0], below_deg[1]);
  // The part of a line on the globe's back is left out.
  const seen = (places) => path(places.map(view).map((point) => point[2] > 0 && point));
  const line = (as, places) => shape("path", as, { d: seen(places) });
  const arc = (of) => Array.from({ length: 49 }, (_, k) => of(k / 48));
  let text = shape("circle", "sea", { cx: CENTRE[0], cy: CENTRE[1], r: RADIUS });
  for (let lon = -180; lon < 180; lon += 30)
    text += line(
      "grid",
      arc((part) => [180 * part - 90, lon]),
    );
  for (let lat = -60; lat <= 60; lat += 30)
    text += line(
      "grid",
      arc((part) => [lat, 360 * part]),
    );
  for (const tenths of coast) {
    const places = tenths.filter((_, k) => k % 2 === 0).map((lon, k) => [tenths[2 * k + 1] / 10, lon / 10]);
    text += line("coast", places);
  }
  text += night(sun_deg, view) + line("track", track);
  for (const part of ["outside", "dark", "lit"]) {
    const pieces = limb.map(([lat, lon, is], k) => {
      const [toLat, toLon, next] = limb[(k + 1) % limb.length];
      const drawn = is === part && (part === "outside" || next === part);
      return drawn
        ? seen([
            [lat, lon],
            [toLat, toLon],
          ])
        : "";
    });
    text += shape("path", part, { d: pieces.join("") });
  }
  const disc = (as, [cx, cy]) => shape("circle", as, { cx, cy, r: 4.5 });
  const zenith = view(sun_deg);
  if (zenith[2] > 0) text += disc("sun", zenith);
  text += disc("sat", view(below_deg));
  Object.entries(KEYS).forEach(([as, name], k) => {
    const y = 44 + 21 * k;
    const isDisc = as === "sat" || as === "sun";
    text += isDisc ? disc(as, [214, y - 4]) : shape("path", as, { d: `M207 ${y - 4}h14` });
    text += words("key", 230, y, name);
  });
  svg.innerHTML = text;
}

/** Latitude and longitude as people write them. */
export function place([latitude, longitude]) {
  const side = (value, up, down) => `${Math.abs(value).toFixed(1)}° ${value < 0 ? down : up}`;
  return `${side(latitude, "N", "S")}, ${side(longitude, "E", "W")}`;
}
