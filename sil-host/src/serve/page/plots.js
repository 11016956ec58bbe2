// Plots over the time of the run, as text of SVG.
//
// In: rows (arrays of values), the columns to draw, the seconds from and to, the second that is shown. Out:
// the inside of an <svg>. What is null is a gap.

import { clock, path, shape, short, words } from "/svg.js";

/** Room beside and below a plot, px. */
const LEFT = 42;
const RIGHT = 6;
const BOTTOM = 15;
/** Seconds between two times written below a plot. */
const STEPS = [
  1, 2, 5, 10, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400, 21600, 43200, 86400, 172800,
];

/** Stretches of seconds with equal words: [from, until, word], empty words left out. */
export function stretches(rows, from, to, wordOf) {
  const found = [];
  for (let second = from; second <= to; second++) {
    const word = wordOf(rows[second]);
    const last = found[found.length - 1];
    if (last && last[2] === word && last[1] === second) last[1] = second + 1;
    else if (word) found.push([second, second + 1, word]);
  }
  return found;
}

/** What is drawn behind every plot: Sun, darkness, faults, the time's ticks. */
function behind({ rows, columns, from, to, x, width }, height) {
  let svg = "";
  const shade = (as, is) => {
    for (const [begin, end] of stretches(rows, from, Math.min(to, rows.length - 1), is)) {
      svg += shape("rect", as, { x: x(begin), y: 0, width: Math.max(1, x(end) - x(begin)), height });
    }
  };
  const state = columns.sensor_state;
  shade("dark", (row) => row[state] === 2);
  shade("sun", (row) => row[state] === 1 || row[state] > 2);
  shade("fault", (row) => row[columns.faults]);
  const step = STEPS.find((s) => (s / (to - from)) * (width - LEFT - RIGHT) >= 62) ?? STEPS.at(-1);
  for (let second = Math.ceil(from / step) * step; second <= to; second += step) {
    const at = x(second);
    svg += shape("path", "grid", { d: `M${at.toFixed(1)} 0V${height}` });
    if (at > LEFT + 16 && at < width - 20) svg += words("tick", at, height + 11, clock(second), "middle");
  }
  return svg;
}

/** Least and greatest value of every bin of seconds: [second, least, greatest, second column's greatest]. */
function bins(rows, from, to, most, value, beside) {
  const size = Math.max(1, Math.ceil((to - from + 1) / most)),
    found = [];
  for (let begin = from; begin <= to; begin += size) {
    let low = null,
      high = null,
      more = null;
    for (let second = begin; second < begin + size && second <= to; second++) {
      const at = value(rows[second]);
      if (at === null) continue;
      low = low === null ? at : Math.min(low, at);
      high = high === null ? at : Math.max(high, at);
      const other = beside ? beside(rows[second]) : null;
      if (other !== null) more = more === null ? other : Math.max(more, other);
    }
    found.push([begin + (size - 1) / 2, low, high, more]);
  }
  return found;
}

/** Ticks of a symmetric scale: the roundest values that leave room for their words. */
function ticks(top, place, room) {
  const found = [];
  for (let decade = 4; decade >= -4; decade--) {
    for (const lead of [1, 5, 2]) {
      const value = lead * 10 ** decade;
      if (value > top) continue;
      const at = place(value);
      if (at > 11 && found.every((other) => Math.abs(place(other) - at) > 11) && at < room - 4)
        found.push(value);
    }
  }
  return found.slice(0, 3);
}

/**
 * Errors with their three sigmas, an axis below the other. The scale is even up to the usual three sigmas and
 * logarithmic beyond, so that the first guess and what the filter makes of it are on one plot.
 */
export function errors(svg, view, axes) {
  const plot = layout(svg, view);
  const height = svg.clientHeight - BOTTOM;
  const tall = height / axes.length;
  const text = axes.map((axis, number) => errorAxis(plot, axis, tall * (number + 0.5), tall / 2 - 3));
  svg.innerHTML = behind(plot, height) + text.join("") + marked(plot, height);
}

/** An axis of errors about `middle`, `half` up and down. */
function errorAxis({ rows, from, to, x, width }, { name, error, sigma }, middle, half) {
  const last = Math.min(to, rows.length - 1);
  const found = bins(
    rows,
    from,
    last,
    width - LEFT,
    (row) => row[error],
    (row) => row[sigma],
  );
  const known = found.filter((bin) => bin[1] !== null);
  let text = shape("rect", "ground", {
    x: LEFT,
    y: middle - half - 1,
    width: width - LEFT - RIGHT,
    height: 2 * half + 2,
  });
  text += words("name", 3, middle + 4, name);
  if (!known.length) return text + words("none", LEFT + 8, middle + 4, "nothing known in this time");
  const sigmas = known.map((bin) => 3 * (bin[3] ?? 0)).sort((a, b) => a - b);
  const greatest = Math.max(...known.map((bin) => Math.max(3 * (bin[3] ?? 0), -bin[1], bin[2])), 1e-9);
  const knee = sigmas[Math.floor(sigmas.length / 2)] || greatest;
  const top = 1.25 * Math.max(knee, greatest);
  const up = (value) => (half * Math.asinh(value / knee)) / Math.asinh(top / knee);
  const y = (value) => middle - Math.max(-half, Math.min(half, up(value)));
  for (const value of ticks(top, up, half)) {
    const size = Number(value.toPrecision(1)).toLocaleString("en");
    for (const [at, label] of [
      [y(value), size],
      [y(-value), `−${size}`],
    ]) {
      text += shape("path", "grid", { d: `M${LEFT} ${at.toFixed(1)}H${width - RIGHT}` });
      text += words("tick", LEFT - 3, at + 3.5, label, "end");
    }
  }
  text += shape("path", "zero", { d: `M${LEFT} ${middle.toFixed(1)}H${width - RIGHT}` });
  const edge = (side) => found.map((bin) => bin[3] !== null && [x(bin[0]), y(3 * side * bin[3])]);
  text += band(edge(1), edge(-1));
  text += shape("path", "line", { d: path(strokes(found, x, y)) });
  for (const [second, low, high, told] of known) {
    const worst = high > -low ? high : low;
    if (told !== null && Math.abs(worst) > 3 * told) {
      text += shape("circle", "beyond", { cx: x(second), cy: y(worst), r: 1.6 });
    }
  }
  return text;
}

/** A line through bins: up and down in each that has more than one value. */
function strokes(found, x, y) {
  return found.flatMap(([second, low, high]) => {
    if (low === null) return [null];
    const ends = [
      [x(second), y(low)],
      [x(second), y(high)],
    ];
    return low === high ? ends.slice(1) : ends;
  });
}

/** The area between two lines, in the pieces in which both are known. */
function band(upper, lower) {
  let text = "";
  let piece = [];
  for (let k = 0; k <= upper.length; k++) {
    if (upper[k]) {
      piece.push(k);
      continue;
    }
    const back = [...piece].reverse();
    if (piece.length) {
      const around = [...piece.map((i) => upper[i]), ...back.map((i) => lower[i])];
      text += shape("path", "band", { d: `${path(around)}Z` });
    }
    piece = [];
  }
  return text;
}

/** Counts and times, each on a strip of its own from zero to its greatest value. */
export function counts(svg, view, lines) {
  const plot = layout(svg, view);
  const { rows, from, to, x, width } = plot;
  const height = svg.clientHeight - BOTTOM;
  const tall = height / lines.length;
  const room = tall - 6;
  const last = Math.min(to, rows.length - 1);
  let text = behind(plot, height);
  lines.forEach(({ name, value, second }, number) => {
    const floor = tall * (number + 1) - 3;
    const found = bins(rows, from, last, width - LEFT, (row) => row[value], null);
    const greatest = Math.max(0, ...found.map((bin) => bin[2] ?? 0));
    const y = (of) => floor - (room * of) / (1.05 * greatest || 1);
    const known = found.some((bin) => bin[1] !== null);
    text += shape("rect", "ground", {
      x: LEFT,
      y: floor - room,
      width: width - LEFT - RIGHT,
      height: room,
    });
    if (greatest) text += words("tick", LEFT - 3, floor - room + 8, short(greatest), "end");
    text += words("tick", LEFT - 3, floor, "0", "end");
    text += shape("path", second ? "line second" : "line", { d: path(strokes(found, x, y)) });
    text += words("name", LEFT + 6, floor - room + 12, known ? name : `${name}: not kept`);
  });
  svg.innerHTML = text + marked(plot, height);
}

function layout(svg, { rows, columns, from, to, cursor }) {
  const width = svg.clientWidth;
  svg.setAttribute("viewBox", `0 0 ${width} ${svg.clientHeight}`);
  const x = (second) => LEFT + ((second - from) / Math.max(1, to - from)) * (width - LEFT - RIGHT);
  return { rows, columns, from, to, cursor, width, x };
}

function marked({ cursor, from, to, x }, height) {
  if (cursor < from || cursor > to) return "";
  return shape("path", "cursor", { d: `M${x(cursor).toFixed(1)} 0V${height}` });
}

/** The second at a place of a plot that shows those from and to. */
export function secondAt(svg, clientX, [from, to]) {
  const { left, width } = svg.getBoundingClientRect();
  const share = (clientX - left - LEFT) / (width - LEFT - RIGHT);
  return Math.round(from + Math.max(0, Math.min(1, share)) * (to - from));
}

/** The modes of the run and its faults, also those to come, in one strip. */
export function modes(svg, rows, columns, { faults, run: { duration_s: duration } }, cursor) {
  svg.setAttribute("viewBox", `0 0 ${duration} 14`);
  svg.setAttribute("preserveAspectRatio", "none");
  const last = rows.length - 1;
  let text = "";
  for (const [from, until, mode] of stretches(rows, 0, last, (row) => row[columns.mode])) {
    text += shape("rect", mode, { x: from, y: 0, width: until - from, height: 14 });
  }
  const broken = stretches(rows, 0, last, (row) => (row[columns.faults] ? "fault" : ""));
  for (const [from, until] of [...broken, ...faults.map(({ from_s, until_s }) => [from_s, until_s])]) {
    text += shape("rect", "fault", {
      x: from,
      y: 9,
      width: Math.max(until - from, duration / 500),
      height: 5,
    });
  }
  svg.innerHTML = text + shape("rect", "now", { x: cursor, y: 0, width: duration / 600, height: 14 });
}
