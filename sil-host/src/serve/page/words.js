// What a second says in words: the sentence, the numbers, the events.
//
// In: rows, whose values are named by the columns set once. Out: text, and how it is to be taken: good, doubt,
// bad.

import { short } from "/svg.js";

export const MODE_WORDS = {
  "self-test": "Self-test",
  acquisition: "Acquisition",
  tracking: "Tracking",
  eclipse: "Eclipse",
  "sun-outage": "Sun outage",
  safe: "Safe",
};

/** What is flown about, by the run's word for it, and what goes round with it. */
export const BODIES = {
  earth: { name: "Earth", neighbour: "Moon" },
  moon: { name: "Moon", neighbour: "Earth" },
  mars: { name: "Mars" },
};

/** Places of the columns in a row, by name. */
export const columns = {};

/** Sets the columns' names, in their order. */
export function setColumns(names) {
  names.forEach((name, place) => (columns[name] = place));
}

/** A value of a row by its column's name. */
export const of = (row, name) => row[columns[name]];
const three = (row, head, axes, tail) => axes.map((axis) => of(row, head + axis + tail));
const XYZ = ["x", "y", "z"];
const RAC = ["radial", "along", "cross"];
const size = (values) => Math.hypot(...values);

/** Columns of an error and its sigma, axis by axis. */
export const ATTITUDE = XYZ.map((axis) => [
  axis,
  `attitude_error_${axis}_arcsec`,
  `attitude_sigma_${axis}_arcsec`,
]);
export const POSITION = RAC.map((axis) => [axis, `position_error_${axis}_km`, `position_sigma_${axis}_km`]);
const both = (row, axes) => [
  axes.map(([, error]) => of(row, error)),
  axes.map(([, , sigma]) => of(row, sigma)),
];

/** The answer: attitude and position against the truth, and whether the errors are within three sigmas. */
export function answer(row) {
  const [attitude, attitudeSigma] = both(row, ATTITUDE);
  const [position, positionSigma] = both(row, POSITION);
  const known = [];
  let words = "";
  if (attitude[0] !== null) {
    known.push([attitude, attitudeSigma]);
    const [off, sigma] = [attitude, attitudeSigma].map((axes) => axes.map(short).join(", "));
    words = `Attitude off by ${off} arcsec about x, y, z (1σ ${sigma}).`;
  } else {
    const rate = three(row, "rate_", XYZ, "_deg_s");
    words =
      rate[0] === null
        ? `No attitude (${of(row, "status")}).`
        : `No attitude, but the rate: ${short(size(rate))} deg/s.`;
  }
  if (position[0] === null) {
    words += " No orbit yet.";
  } else {
    // A record of an older version has no sigmas along the orbit's axes.
    const told = positionSigma[0] !== null;
    if (told) known.push([position, positionSigma]);
    const sigma = told ? ` (1σ ${short(size(positionSigma))})` : "";
    words += ` Position off by ${short(size(position))} km${sigma}.`;
  }
  const right = known.every(([error, sigma]) => error.every((e, axis) => Math.abs(e) <= 3 * sigma[axis]));
  if (!right) words += " More than 3σ.";
  return { words, grade: !right ? "bad" : attitude[0] === null ? "doubt" : "good" };
}

/** The numbers of a second: what, value, how it is to be taken; `body` is flown about. */
export function numbers(row, look, body) {
  const triple = (values) => (values[0] === null ? "–" : values.map(short).join(", "));
  const mode = MODE_WORDS[of(row, "mode")] ?? of(row, "mode");
  const right = of(row, "mode_right"),
    reported = of(row, "reported_faults");
  return [
    [
      "Mode",
      right === 0 ? `${mode}, should be ${of(row, "expected_mode")}` : mode,
      right === 0 ? "bad" : "good",
    ],
    ["Stars", `${of(row, "stars")} of ${of(row, "detections")} spots, ${of(row, "status")}`, ""],
    ["Wrong names", look.log10_false === null ? "–" : `1 in 10^${Math.round(-look.log10_false)}`, ""],
    ["Rate, deg/s", short(look.rate_deg_s), ""],
    [body.name, `${of(row, "earth_status")}, lit limb ${short(of(row, "lit_limb_deg"))}°`, ""],
    [
      "Its centre",
      look.earth ? `${short(look.earth.distance_km)} ± ${short(look.earth.sigma_km)} km` : "–",
      "",
    ],
    ["Position off, km", triple(both(row, POSITION)[0]), ""],
    ["Velocity off, m/s", triple(three(row, "velocity_error_", RAC, "_m_s")), ""],
    ["Sensor reports", reported ?? "no fault", reported && !reported.startsWith("crowded") ? "bad" : ""],
  ];
}

/** What happened: second, words, whether it is a fault; the first one first. */
export function events(rows) {
  const found = [];
  let broken = "";
  rows.forEach((row, second) => {
    const fault = of(row, "faults") ?? "";
    if (fault !== broken)
      found.push([second, fault ? `broken: ${fault}` : "nothing broken any more", fault ? "fault" : ""]);
    broken = fault;
    const words = of(row, "events");
    if (words) found.push([second, words, ""]);
  });
  return found;
}
