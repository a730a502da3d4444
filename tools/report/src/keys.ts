// The keyboard, and the card that explains it.
import { h } from "./dom";
import type { Replay } from "./replay";
import type { State } from "./state";

const help: [string, string][] = [
  ["space", "play, pause"],
  ["← →", "0.1 s back, forward (with shift 1 s)"],
  [", .", "one step back, forward"],
  ["home end", "to the start, to the end"],
  ["[ ]", "slower, faster"],
  ["f", "follow the car"],
  ["n", "next car"],
  ["z + −", "whole track, larger, smaller"],
  ["p r a t l", "plan, references, force arrows, trail, line"],
  ["1 … 9", "show or hide a stack (with shift: alone)"],
  ["?", "this card"],
];

export function helpCard(): HTMLDialogElement {
  const card = h(
    "dialog",
    { class: "help", "aria-label": "Keyboard" },
    h("h2", {}, "Keyboard"),
    h("dl", {}, ...help.flatMap(([keys, words]) => [h("dt", {}, ...keys.split(" ").map((key) => h("kbd", {}, key))), h("dd", {}, words)])),
    h("p", { class: "note" }, "Drag across a chart to zoom, double-click to see all again."),
    h("form", { method: "dialog" }, h("button", { class: "quiet" }, "Close")),
  );
  card.addEventListener("click", (event) => event.target === card && card.close());
  return card;
}

const layers = { p: "plan", r: "references", a: "forces", t: "trail", l: "line" } as const;
const rates = [0.1, 0.25, 0.5, 1, 2, 4];

export function bindKeys(state: State, replay: Replay | null, card: HTMLDialogElement): void {
  const { clock } = state;
  const nextCar = () => {
    const shown = state.runs().map((run) => run.stack);
    if (shown.length) state.setFocus(shown[(shown.indexOf(state.focus) + 1) % shown.length]);
  };
  const changeRate = (by: number) => clock.setRate(rates[Math.min(Math.max(rates.indexOf(clock.rate) + by, 0), rates.length - 1)]);
  const seek = (by: number) => {
    clock.pause();
    clock.seek(clock.t + by);
  };
  const step = state.report.meta.scene?.dt ?? 0.02;
  const actions: Record<string, (event: KeyboardEvent) => void> = {
    " ": () => clock.toggle(),
    k: () => clock.toggle(),
    ArrowLeft: (event) => seek(event.shiftKey ? -1 : -0.1),
    ArrowRight: (event) => seek(event.shiftKey ? 1 : 0.1),
    ",": () => seek(-step),
    ".": () => seek(step),
    Home: () => seek(-Infinity),
    End: () => seek(Infinity),
    "[": () => changeRate(-1),
    "]": () => changeRate(1),
    f: () => replay?.follow(!replay.following),
    n: nextCar,
    z: () => replay?.follow(false),
    "+": () => replay?.zoomBy(1.4),
    "=": () => replay?.zoomBy(1.4),
    "-": () => replay?.zoomBy(1 / 1.4),
    "?": () => card.showModal(),
  };
  for (const [key, layer] of Object.entries(layers)) actions[key] = () => replay?.toggleLayer(layer);

  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || card.open) return;
    const target = event.target as HTMLElement;
    // The slider of time obeys the same keys as the rest of the page.
    if (target.closest("input:not([type=range]), select, textarea, [contenteditable]")) return;
    if (event.key === " " && target.closest("button, a, summary")) return;
    const digit = /^Digit([1-9])$/.exec(event.code);
    if (digit) {
      const stack = Number(digit[1]) - 1;
      if (stack >= state.report.meta.stacks.length) return;
      if (event.shiftKey) state.solo(stack);
      else state.toggle(stack);
      return;
    }
    // Arrow keys scroll tables that have the focus.
    if (event.key.startsWith("Arrow") && target.closest(".table-scroll")) return;
    const action = actions[event.key];
    if (!action || (!replay && event.key !== "?")) return;
    event.preventDefault();
    action(event);
  });
}
