// Which lap a figure shows.
import { h } from "./dom";

const mostButtons = 12;

/** Buttons for a few laps, a list for many; null is all laps, where the figure can show them. */
export function lapChoice(count: number, first: number | null, choose: (lap: number | null) => void): HTMLElement {
  const choices = [...(first === null ? [null] : []), ...Array.from({ length: count }, (_, i) => i)];
  const name = (choice: number | null) => (choice === null ? "all laps" : `lap ${choice}`);
  if (choices.length > mostButtons) {
    const select = h("select", { "aria-label": "Lap" }, ...choices.map((choice) => h("option", {}, name(choice))));
    select.addEventListener("change", () => choose(choices[select.selectedIndex]));
    return select;
  }
  const buttons = choices.map((choice) => h("button", { type: "button", class: "quiet", "aria-pressed": String(choice === first) }, name(choice)));
  buttons.forEach((button, i) =>
    button.addEventListener("click", () => {
      buttons.forEach((b, k) => b.setAttribute("aria-pressed", String(k === i)));
      choose(choices[i]);
    }),
  );
  return h("span", { class: "group", role: "group", "aria-label": "Lap" }, ...buttons);
}
