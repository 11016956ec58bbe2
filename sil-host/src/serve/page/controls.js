// Buttons, forms and keys.

import { $, moveTo, order, run, say, setSpeed, stepOn, toggle } from "/run.js";

const SPEEDS = { "1×": 1, "10×": 10, "60×": 60, max: null };
const SPANS = { "2 min": 120, "15 min": 900, "2 h": 7200, all: null };

/** What is drawn over the frame, and the seconds that are plotted (null: all). */
export const shown = { windows: true, stars: true, limb: true, span: SPANS["15 min"] };

/** A button of a group. */
function button(parent, words, act) {
  const made = document.createElement("button");
  made.textContent = words;
  made.type = "button";
  made.addEventListener("click", act);
  $(parent).append(made);
  return made;
}

/** Keys, wherever they are not typed into a field or press what has the focus. */
function key(event) {
  const { tagName, type, id } = event.target;
  const presses = tagName === "BUTTON" || type === "checkbox";
  const types = tagName === "SELECT" || (tagName === "INPUT" && type !== "range" && type !== "checkbox");
  if (types || event.ctrlKey || event.altKey || event.metaKey || (presses && event.key === " ")) return;
  const acts = {
    " ": toggle,
    ArrowRight: stepOn,
    ArrowLeft: () => moveTo(run.cursor - 1),
    PageUp: () => moveTo(run.cursor + 60),
    PageDown: () => moveTo(run.cursor - 60),
    Home: () => moveTo(0),
    End: () => moveTo(run.rows.length - 1),
  };
  // The list of events scrolls by its own keys.
  if (!acts[event.key] || (id === "events" && event.key !== " ")) return;
  event.preventDefault();
  acts[event.key]();
}

/** What does not depend on the run: groups of buttons, scenarios, records. */
export function fill({ scenarios, recorded, faults }) {
  for (const [words, times] of Object.entries(SPEEDS)) {
    button("speed", words, () => setSpeed(times)).dataset.speed = String(times);
  }
  for (const [words, seconds] of Object.entries(SPANS)) {
    const made = button("span", words, () => {
      shown.span = seconds;
      for (const other of $("span").children) other.setAttribute("aria-pressed", other === made);
      run.changed = true;
    });
    made.setAttribute("aria-pressed", seconds === shown.span);
  }
  for (const { label, kind, seconds } of faults) {
    const made = button("faults", label, () => order({ do: "fault", kind }));
    made.dataset.kind = kind;
    made.title = `${kind} for ${seconds} s`;
  }
  for (const { name, description } of scenarios) {
    const option = new Option(name, name);
    option.title = description;
    $("scenarios").append(option);
  }
  $("scenarios").addEventListener("change", (event) => {
    $("new-seed").value = scenarios[event.target.selectedIndex].seed;
  });
  for (const folder of recorded) $("folders").append(new Option(folder, folder));
}

/** Has buttons, forms and keys obeyed; `redraw` draws the frame's overlay again. */
export function obey(redraw) {
  document.addEventListener("keydown", key);
  // A button pressed by the mouse gives the keyboard back, so that the space bar starts and pauses.
  document.addEventListener("pointerup", (event) => event.target.closest?.("button")?.blur());
  addEventListener("resize", () => (run.changed = true));
  $("start").addEventListener("click", toggle);
  $("step").addEventListener("click", () => {
    moveTo(run.rows.length - 1);
    order({ do: "step", seconds: 1 });
  });
  $("cursor").addEventListener("input", (event) => moveTo(Number(event.target.value)));
  $("fly").addEventListener("submit", (event) => {
    event.preventDefault();
    order({ do: "fly", scenario: $("scenarios").value, seed: Number($("new-seed").value) });
  });
  $("open").addEventListener("submit", (event) => {
    event.preventDefault();
    say("The recorded run is being read …", true);
    order({ do: "open", folder: $("folder").value });
  });
  for (const what of ["windows", "stars", "limb"]) {
    $(`show-${what}`).addEventListener("change", (event) => {
      shown[what] = event.target.checked;
      redraw();
    });
  }
}
