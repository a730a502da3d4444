// A stack's sign beside its name: its colour and its marker, so that neither is needed alone.
import { drawMarker, SvgPen } from "./pen";
import { stackDash, stackShape } from "./theme";

/** The colour comes from the style sheet, and so follows the reader's scheme and paper. */
function coloured(pen: SvgPen, stack: number, className: string): SVGElement {
  const element = pen.element(className);
  element.setAttribute("style", `color: var(--s${stack % 10})`);
  return element;
}

export function swatch(stack: number): SVGElement {
  const pen = new SvgPen(12, 12, "none");
  drawMarker(pen, stackShape(stack), 6, 6, 4, "currentColor");
  return coloured(pen, stack, "swatch");
}

/** A piece of the stack's line with its marker on it; dashed if the stack is given the ground truth. */
export function lineSwatch(stack: number, truth: boolean): SVGElement {
  const pen = new SvgPen(22, 12, "none");
  pen.line([0, 6, 22, 6], { color: "currentColor", width: 2.4, dash: stackDash(truth) });
  drawMarker(pen, stackShape(stack), 11, 6, 3.6, "currentColor");
  return coloured(pen, stack, "line-swatch");
}
