// Colours: one place, read from the style sheet so that light, dark and print agree.

/** Marker shapes go with the colours, so that neither is needed to tell stacks apart. */
export const shapes = ["circle", "square", "triangle", "diamond", "plus", "cross", "star", "wedge", "ring", "bar"] as const;
export type Shape = (typeof shapes)[number];

const cache = new Map<string, string>();

/** The value of a custom property of the page. */
export function token(name: string): string {
  let value = cache.get(name);
  if (value === undefined) {
    value = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
    cache.set(name, value);
  }
  return value;
}

export function stackColour(stack: number): string {
  return token(`s${stack % 10}`);
}
export function stackShape(stack: number): Shape {
  return shapes[stack % shapes.length];
}
/** Stacks that are given the ground truth are dashed everywhere. */
export function stackDash(truth: boolean): number[] | undefined {
  return truth ? [6, 4] : undefined;
}

/** Calls back when the reader's scheme changes, and around printing, which is always light. */
export function onThemeChange(listener: () => void): void {
  const changed = () => {
    cache.clear();
    listener();
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
  matchMedia("print").addEventListener("change", changed);
  new MutationObserver(changed).observe(document.documentElement, { attributeFilter: ["data-theme"] });
}

// Viridis (van der Walt, Smith 2015) at ten places: even in lightness, made for readers with any colour vision.
const viridis = ["#440154", "#482878", "#3e4a89", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"];

function channels(hex: string): [number, number, number] {
  return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16)) as [number, number, number];
}

/** Sequential colour for a share of 0..1. The dark end is lifted on dark paper, the light end lowered on light paper. */
export function sequential(share: number): string {
  const dark = token("scheme") === "dark";
  const [from, to] = dark ? [0.22, 1] : [0, 0.93];
  const place = (from + (to - from) * Math.min(Math.max(share, 0), 1)) * (viridis.length - 1);
  const i = Math.min(Math.floor(place), viridis.length - 2);
  const [a, b] = [channels(viridis[i]), channels(viridis[i + 1])];
  return `rgb(${a.map((v, k) => Math.round(v + (place - i) * (b[k] - v))).join(" ")})`;
}
