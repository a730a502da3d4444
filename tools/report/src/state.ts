// What the reader has chosen: the stacks and the seed shown, the one looked at, and the replay's clock.
import type { Report } from "./data";
import { RunData } from "./data";
import { intervals, laps } from "./mapview";
import type { TableRow } from "./types";

type Listener = () => void;

/** A run that is lost shows it this long before it leaves the road or its end [s]. */
const losing = 3;

/** Something that tells others when it changed. */
class Source {
  private readonly listeners = new Set<Listener>();
  on(listener: Listener): void {
    this.listeners.add(listener);
  }
  emit(): void {
    for (const listener of this.listeners) listener();
  }
}

export class Clock {
  readonly moved = new Source();
  readonly changed = new Source();
  t = 0;
  end = 0;
  rate = 1;
  playing = false;
  private last = 0;
  private stop = Infinity;

  /** Plays until t and stops there. */
  playUntil(t: number): void {
    this.stop = t;
    this.start();
  }
  seek(t: number): void {
    this.t = Math.min(Math.max(t, 0), this.end);
    this.moved.emit();
  }
  toggle(): void {
    if (this.playing) this.pause();
    else this.play();
  }
  play(): void {
    this.stop = Infinity;
    this.start();
  }
  private start(): void {
    if (this.t >= Math.min(this.end, this.stop)) this.t = 0;
    this.playing = true;
    this.last = performance.now();
    this.changed.emit();
    requestAnimationFrame((now) => this.frame(now));
  }
  pause(): void {
    this.playing = false;
    this.changed.emit();
  }
  setRate(rate: number): void {
    this.rate = rate;
    this.changed.emit();
  }
  private frame(now: number): void {
    if (!this.playing) return;
    // A tab that was asleep must not jump.
    const step = Math.min(now - this.last, 100) / 1000;
    this.last = now;
    this.seek(this.t + step * this.rate);
    if (this.t >= Math.min(this.end, this.stop)) this.pause();
    else requestAnimationFrame((next) => this.frame(next));
  }
}

export class State {
  /** Stacks, seed or theme changed: pictures are stale. */
  readonly changed = new Source();
  /** Another stack is under the pointer, or none: emphasis only. */
  readonly hovered = new Source();
  readonly clock = new Clock();
  readonly visible: Set<number>;
  seed: string;
  hot: number | null = null;
  /** All lines in their colours, however many there are. */
  alike = false;
  /** The stack whose car the replay follows and whose numbers the dial shows. */
  focus = 0;

  constructor(readonly report: Report) {
    this.visible = new Set(report.meta.stacks.keys());
    this.seed = report.seeds[0] ?? "";
    this.focus = this.mostInteresting();
    this.updateEnd();
    this.clock.t = this.demoLap()[0];
  }
  /** Of the stacks that were not told the truth and finished, the one whose last lap and time outside together are least. */
  private mostInteresting(): number {
    const { report } = this;
    const { meta } = report;
    const lastLap = report.filled(/^lap\d+_s$/).pop() ?? "";
    const value = (row: TableRow, column: string) => row.values[report.column(column)] ?? Infinity;
    const outside = (row: TableRow) => value(row, "violation_s");
    // Who did not finish was not outside after that.
    const lost = (row: TableRow) => Number(report.finished(row) === 0);
    const ranks = (row: TableRow) => [lost(row), value(row, lastLap) + outside(row), outside(row)];
    const own = meta.table.rows.filter((row) => !meta.stacks[row.stack].truth && meta.runs.some((run) => run.stack === row.stack && run.block));
    own.sort((a, b) => {
      const [first, second] = [ranks(a), ranks(b)];
      const at = first.findIndex((v, i) => v !== second[i]);
      return at < 0 ? 0 : first[at] - second[at];
    });
    return own[0]?.stack ?? Math.max(0, meta.runs.find((run) => run.block)?.stack ?? 0);
  }
  data(stack: number): RunData | undefined {
    return this.report.run(stack, this.seed);
  }
  /** The runs on show, in the order of the table. */
  runs(): RunData[] {
    return this.report.meta.stacks.flatMap((_, stack) => {
      const run = this.visible.has(stack) ? this.data(stack) : undefined;
      return run ? [run] : [];
    });
  }
  /** When a run stopped telling how its stack drives: it left the road and never came back, or hit a wall. */
  until(run: RunData): number {
    if (run.goesOn) return Infinity;
    const last = intervals(run, "outside").pop();
    return Math.max(0, (last && last[1] >= run.end - 5 ? last[0] : run.end) - losing);
  }
  /** Until when charts over time reach: a run that takes far longer than most does not push the others aside. */
  get shownEnd(): number {
    const ends = this.runs().filter((run) => run.goesOn).map((run) => run.end).sort((a, b) => a - b);
    if (ends.length < 3) return this.clock.end;
    const usual = 1.25 * ends[ends.length >> 1];
    return Math.max(...ends.filter((end) => end <= usual));
  }
  /** More lines in one picture than can be told apart. */
  get crowded(): boolean {
    return this.runs().length > 4;
  }
  /** The stack in colour where lines lie over one another, the others being grey; null: all are. */
  get lit(): number | null {
    if (this.hot !== null) return this.hot;
    return this.crowded && !this.alike && this.data(this.focus) && this.visible.has(this.focus) ? this.focus : null;
  }
  /** Lap 1 of the car followed; the only lap, where there is no other. */
  demoLap(): [number, number] {
    const run = this.data(this.focus);
    if (!run) return [0, 0];
    const all = laps(run);
    return all[1] ?? all[0] ?? [0, run.end];
  }
  setAlike(alike: boolean): void {
    this.alike = alike;
    this.update();
  }
  toggle(stack: number): void {
    if (this.visible.has(stack)) this.visible.delete(stack);
    else this.visible.add(stack);
    this.update();
  }
  /** Shows one stack alone, or all again. */
  solo(stack: number): void {
    const alone = this.visible.size === 1 && this.visible.has(stack);
    this.visible.clear();
    for (const i of alone ? this.report.meta.stacks.keys() : [stack]) this.visible.add(i);
    this.update();
  }
  setSeed(seed: string): void {
    this.seed = seed;
    this.update();
  }
  setFocus(stack: number): void {
    this.focus = stack;
    this.visible.add(stack);
    this.update();
  }
  hover(stack: number | null): void {
    if (this.hot === stack) return;
    this.hot = stack;
    this.hovered.emit();
  }
  update(): void {
    this.updateEnd();
    this.changed.emit();
  }
  private updateEnd(): void {
    // Who crashed or lost the road does not say how long the others are shown.
    const runs = this.runs();
    const going = runs.filter((run) => run.goesOn);
    this.clock.end = Math.max(0, ...(going.length ? going : runs).map((run) => run.end));
    if (this.clock.t > this.clock.end) this.clock.t = this.clock.end;
  }
}
