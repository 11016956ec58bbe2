// The page: draws the run at its cursor.

import { fill, obey, shown } from "/controls.js";
import { overlay } from "/frame.js";
import { globe, place } from "/globe.js";
import { counts, errors, modes, secondAt } from "/plots.js";
import { $, get, isOver, moveTo, play, poll, run, say, whenBegun } from "/run.js";
import { earthDisc, sky } from "/sky.js";
import { clock, short } from "/svg.js";
import {
  answer,
  ATTITUDE,
  BODIES,
  columns,
  events,
  MODE_WORDS,
  numbers,
  of,
  POSITION,
  setColumns,
} from "/words.js";

const EVENTS_SHOWN = 200;
const TRACK_POINTS = 1500;
/** Least time from a drawing to the next, and from a second looked at to the next, ms. */
const DRAWN_EVERY = 80;
const LOOKED_EVERY = 120;
const AFTER_FAILURE = 2000;
/** What is empty before a run's first second. */
const PANELS = [
  "figures",
  "events",
  "overlay",
  "sky",
  "globe",
  "attitude",
  "position",
  "counts",
  "below",
  "cycle",
  "frame-words",
];

const stars = [];
const coast = [];
let look = null;
let looking = false;
let listed = 0;
let drawn = 0;

/** A run that was not shown before. */
function begin(title) {
  [look, listed] = [null, 0];
  document.title = `${title.scenario} – Sextant`;
  $("scenario").textContent = title.scenario;
  $("seed").textContent = `seed ${title.seed}`;
  $("source").textContent = title.folder ? `recorded: ${title.folder}` : "live";
  $("body").textContent = BODIES[title.body].name;
  $("utc").textContent = `${title.start_utc.replace("T", " ")} UTC`;
  $("cursor").max = title.duration_s - 1;
  if (!title.folder) {
    $("scenarios").value = title.scenario;
    $("new-seed").value = title.seed;
  }
  for (const id of PANELS) $(id).replaceChildren();
  $("disc").getContext("2d").clearRect(0, 0, $("disc").width, $("disc").height);
  $("frame").hidden = true;
  $("no-frame").textContent = "No second has been flown: press Start.";
  run.changed = true;
}

/** Draws what has changed; `now` in ms. */
function draw(now) {
  requestAnimationFrame(draw);
  if (run.playing) play(now);
  if (!run.changed || !run.state || now - drawn < DRAWN_EVERY) return;
  [run.changed, drawn] = [false, now];
  const { rows, state, cursor } = run;
  controls();
  first(rows[cursor]);
  modes($("modes"), rows, columns, state, cursor);
  if (!rows[cursor]) return;
  const [from, to] = plotted();
  const view = { rows, columns, from, to, cursor };
  const axes = (all) =>
    all.map(([name, error, sigma]) => ({ name, error: columns[error], sigma: columns[sigma] }));
  errors($("attitude"), view, axes(ATTITUDE));
  errors($("position"), view, axes(POSITION));
  counts($("counts"), view, [
    { name: "stars", value: columns.stars },
    { name: "limb points", value: columns.limb_points, second: true },
    { name: "host, ms a second", value: columns.host_ms },
  ]);
  list();
  lookAt();
}

/** The controls as the state has them. */
function controls() {
  const { rows, state, cursor, playing, pace } = run;
  const live = !state.run.folder;
  const about = [state.run.description, live ? "" : state.end.words];
  $("description").textContent = about.filter(Boolean).join(". ");
  $("start").textContent = state.running || playing ? "Pause" : live ? "Start" : "Play";
  $("start").disabled = isOver();
  $("step").disabled = !live || isOver();
  for (const button of $("speed").querySelectorAll("button")) {
    button.setAttribute("aria-pressed", String(live ? state.speed : pace) === button.dataset.speed);
  }
  const acting = rows[cursor] ? (of(rows[cursor], "faults") ?? "").split("+") : [];
  for (const button of $("faults").children) {
    const { kind } = button.dataset;
    button.disabled = !live || isOver() || (kind === "gyro-silent" && !state.run.gyro);
    button.classList.toggle("acts", acting.includes(kind));
  }
  $("cursor").value = cursor;
  $("cursor").setAttribute("aria-valuetext", `${clock(cursor)} after the start`);
  $("since").textContent = `T+${clock(cursor)}`;
}

/** The seconds that are plotted. */
function plotted() {
  const { rows, state, cursor, follows } = run;
  const { span } = shown;
  if (span === null) return [0, Math.max(10, rows.length - 1)];
  const end = follows ? cursor : Math.min(rows.length - 1, cursor + Math.floor(span / 2));
  const to = Math.max(end, Math.min(span, state.run.duration_s) - 1);
  return [Math.max(0, to - span + 1), to];
}

/** What is to be said first: the answer in a sentence, and at the end what the run came to. */
function first(row) {
  const { rows, state, cursor } = run;
  const last = state.end && cursor === rows.length - 1;
  $("end").textContent = last ? state.end.words : "";
  $("end").className = last ? state.end.grade : "";
  const mode = row ? of(row, "mode") : "";
  const start = {
    words: `${clock(state.run.duration_s)} to fly. Start, or one second by Step.`,
    grade: "",
  };
  const { words, grade } = row ? answer(row) : start;
  $("mode").textContent = row ? (MODE_WORDS[mode] ?? mode) : "ready";
  $("mode").className = `mode ${mode}`;
  $("sentence").textContent = words;
  $("answer").className = `answer ${grade}`;
}

/** The list of events, the latest first. */
function list() {
  const found = events(run.rows);
  if (found.length === listed) return;
  listed = found.length;
  const line = ([second, words, as]) => {
    const [item, at, text] = ["li", "button", "span"].map((name) => document.createElement(name));
    at.textContent = clock(second);
    at.setAttribute("aria-label", `Show ${clock(second)}`);
    at.addEventListener("click", () => moveTo(second));
    [text.textContent, text.className] = [words, as];
    item.append(at, text);
    return item;
  };
  $("events").replaceChildren(...found.slice(-EVENTS_SHOWN).reverse().map(line));
}

/** Looks at the second of the cursor: one request after the other, the newest wish only. */
async function lookAt() {
  const isSeen = () => look && look.run === run.number && look.cycle === run.cursor;
  if (looking || isSeen()) return;
  looking = true;
  const number = run.number;
  const query = `run=${number}&cycle=${run.cursor}`;
  let wait = LOOKED_EVERY;
  try {
    const seen = await (await get(`/api/second?${query}`)).json();
    const frame = seen.no_frame ? null : await fetch(`/api/frame?${query}`);
    const picture = frame?.ok ? await frame.blob() : null;
    const why = picture ? "" : (seen.no_frame ?? (await frame.text()).trim());
    if (number === run.number) await show({ ...seen, run: number }, picture, why);
  } catch (error) {
    if (number === run.number) {
      say(error.message);
      wait = AFTER_FAILURE;
    }
  }
  looking = false;
  if (!isSeen()) setTimeout(lookAt, wait);
}

/** Shows a second looked at. */
async function show(seen, picture, why) {
  const image = $("frame");
  if (picture) {
    const old = image.src;
    image.src = URL.createObjectURL(picture);
    if (old.startsWith("blob:")) URL.revokeObjectURL(old);
    await image.decode().catch(() => {});
  }
  image.hidden = !picture;
  look = seen;
  $("no-frame").textContent = why;
  overlay($("overlay"), look, shown);
  const { windows } = look;
  $("show-windows").disabled = windows === null;
  $("windows-words").textContent = windows === null ? "windows not kept" : "windows read";
  const found = `${look.stars.length} stars, ${look.limb_px.length} limb points`;
  const read = windows === null ? "" : `, ${windows.length} windows`;
  $("frame-words").textContent =
    `T+${clock(look.cycle)}: ${look.reported ? found : "stars not kept"}${read}`;
  $("utc").textContent = `${look.utc.replace("T", " ")} UTC`;
  earthDisc($("disc"), look);
  const { body } = run.state.run;
  sky($("sky"), look, stars, BODIES[body]);
  globe($("globe"), look, body === "earth" ? coast : [], track(look.cycle));
  $("below").textContent = `${place(look.globe.below_deg)}, ${short(look.globe.altitude_km)} km high`;
  figures(run.rows[look.cycle]);
}

/** Places of the ground track up to a second. */
function track(until) {
  const step = Math.max(1, Math.ceil(until / TRACK_POINTS));
  const places = run.rows
    .slice(0, until + 1)
    .filter((_, second) => second % step === 0 || second === until);
  return places.map((row) => [of(row, "latitude_deg"), of(row, "longitude_deg")]);
}

/** The numbers of the second. */
function figures(row) {
  if (!row) return;
  $("cycle").textContent = `number ${of(row, "cycle")}`;
  $("figures").replaceChildren();
  for (const [name, value, as] of numbers(row, look, BODIES[run.state.run.body])) {
    const [head, cell] = ["th", "td"].map((tag) => document.createElement(tag));
    head.scope = "row";
    [head.textContent, cell.textContent, cell.className] = [name, value, as];
    $("figures").insertRow().append(head, cell);
  }
}

const fixed = await (await get("/api/page")).json();
setColumns(fixed.columns);
stars.push(...fixed.stars);
coast.push(...(await (await get("/coast.json")).json()));
fill(fixed);
obey(() => look && overlay($("overlay"), look, shown));
for (const id of ["attitude", "position", "counts"]) {
  $(id).addEventListener("click", (event) => moveTo(secondAt($(id), event.clientX, plotted())));
}
whenBegun(begin);
poll(true);
requestAnimationFrame(draw);
