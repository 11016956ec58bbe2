// The run that is shown: its rows so far, the second at the cursor, and the server that knows more.
//
// Rows are arrays of values (words.js names them); the same for a flight and for a recorded run.

/** Seconds that a record goes on in a second when it is played as fast as it goes. */
const PLAYED_MAX = 600;

export const $ = (id) => document.getElementById(id);

/** What is shown. `changed`: there is something to draw; `pace`: a record's speed, times real time. */
export const run = {
  number: null,
  rows: [],
  state: null,
  cursor: 0,
  follows: true,
  playing: false,
  pace: 10,
  changed: true,
};
let begun = () => {};
let played = 0;
let playedAt = 0;

/** Has `act` called with the title of every run that was not shown before. */
export function whenBegun(act) {
  begun = act;
}

/** A line for people; a calm one is no complaint. */
export function say(words, calm) {
  $("message").textContent = words;
  $("message").className = calm ? "calm" : "";
}

/** The answer to a question; what is refused is thrown. */
export async function get(url) {
  const reply = await fetch(url);
  if (!reply.ok) throw new Error((await reply.text()).trim());
  return reply;
}

/** Takes an order to the server, and says what came of it. */
export async function order(words) {
  try {
    const headers = { "Content-Type": "application/json" };
    const reply = await fetch("/api/order", { method: "POST", headers, body: JSON.stringify(words) });
    say(reply.ok ? "" : (await reply.text()).trim());
  } catch {
    say("The program has ended.");
  }
  poll(false);
}

/** Asks for what is new; comes again by itself when `again`. */
export async function poll(again) {
  let wait = 2000;
  try {
    wait = take(await (await get(`/api/state?run=${run.number ?? 0}&since=${run.rows.length}`)).json());
  } catch (error) {
    say(`The program does not answer: ${error.message}`);
  }
  if (again) setTimeout(() => poll(true), wait);
}

/** Takes in an answer about the state; gives how long to wait for the next, ms. */
function take(told) {
  if (told.message) say(told.message);
  else if (told.preparing) say("The world of the flight is being made …", true);
  else if ($("message").className === "calm") say("");
  if (!told.run) return 300;
  if (told.run.run !== run.number) {
    Object.assign(run, { number: told.run.run, rows: [], cursor: 0, follows: true, playing: false });
    begun(told.run);
  }
  if (told.since === run.rows.length && told.rows.length) {
    run.rows.push(...told.rows);
    if (told.run.folder) run.follows = false;
    if (run.follows) run.cursor = run.rows.length - 1;
  }
  const head = ({ running, speed, end, flown, run: { run: number } }) =>
    JSON.stringify([running, speed, end, flown, number]);
  run.changed ||= !run.state || head(run.state) !== head(told);
  run.state = told;
  if (run.rows.length < told.flown) return 0;
  return told.running || told.steps ? 200 : 350;
}

/** Moves the cursor. */
export function moveTo(second) {
  if (!run.rows.length) return;
  run.cursor = Math.max(0, Math.min(run.rows.length - 1, second));
  run.follows = !run.state.run.folder && run.cursor === run.rows.length - 1;
  run.changed = true;
}

/** Whether the flight is over. */
export const isOver = () => !run.state.run.folder && Boolean(run.state.end);

/** Starts or pauses the flight, or the playing of a record. */
export function toggle() {
  if (!run.state || isOver()) return;
  if (!run.state.run.folder) {
    order({ do: run.state.running ? "pause" : "start" });
    return;
  }
  if (!run.playing && run.cursor >= run.rows.length - 1) moveTo(0);
  [played, playedAt] = [0, performance.now()];
  [run.playing, run.changed] = [!run.playing, true];
}

/** Moves the cursor of a record that is played; `now` in ms. */
export function play(now) {
  played += ((now - playedAt) / 1000) * (run.pace ?? PLAYED_MAX);
  playedAt = now;
  const whole = Math.floor(played);
  played -= whole;
  if (whole > 0) moveTo(run.cursor + whole);
  if (run.cursor >= run.rows.length - 1) [run.playing, run.changed] = [false, true];
}

/** Sets how fast it goes, times real time; null: as fast as it goes. */
export function setSpeed(times) {
  if (run.state && !run.state.run.folder) order({ do: "speed", times });
  [run.pace, run.changed] = [times, true];
}

/** A second on: along the run, and at its end in flight a new one. */
export function stepOn() {
  if (run.rows.length && run.cursor < run.rows.length - 1) moveTo(run.cursor + 1);
  else if (run.state && !run.state.run.folder && !isOver()) order({ do: "step", seconds: 1 });
}
