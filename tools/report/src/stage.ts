// One frame of the replay: the course, the cars, and what they think.
import type { Camera } from "./camera";
import { indexBefore, type RunData } from "./data";
import type { Course } from "./mapview";
import { CanvasPen, drawMarker, fontFamily } from "./pen";
import type { Scene } from "./types";
import { stackColour, stackShape, token } from "./theme";

export interface Layers {
  line: boolean;
  trail: boolean;
  plan: boolean;
  references: boolean;
  forces: boolean;
}

export interface CarDimensions {
  length: number;
  width: number;
  lf: number;
  lr: number;
  mass: number;
}

/** The car's size from the scene; without one, a size that can be seen. */
export function carDimensions(scene: Scene | null, course: Course): CarDimensions {
  const car = scene?.car ?? {};
  const length = car.length || (course.box.right - course.box.left) / 60;
  const wheelbase = (car.lf ?? 0) + (car.lr ?? 0) || length * 0.62;
  return { length, width: car.width || length / 2, lf: car.lf || wheelbase / 2, lr: car.lr || wheelbase / 2, mass: car.m ?? 0 };
}

function polygonPath(xs: ArrayLike<number>, ys: ArrayLike<number>): Path2D {
  const path = new Path2D();
  for (let i = 0; i < xs.length; i++) i ? path.lineTo(xs[i], ys[i]) : path.moveTo(xs[i], ys[i]);
  path.closePath();
  return path;
}

export class Stage {
  private readonly surface?: Path2D;
  private readonly edges: Path2D[] = [];
  private readonly line?: Path2D;
  private readonly start?: Path2D;

  constructor(
    course: Course,
    readonly car: CarDimensions,
  ) {
    const { left, right, centre, line } = course;
    if (left && right) {
      this.edges = [polygonPath(...left), polygonPath(...right)];
      this.surface = new Path2D();
      for (const edge of this.edges) this.surface.addPath(edge);
      this.start = new Path2D();
      this.start.moveTo(left[0][0], left[1][0]);
      this.start.lineTo(right[0][0], right[1][0]);
    } else if (centre) {
      this.edges = [polygonPath(...centre)];
    }
    if (line) this.line = polygonPath(...line);
  }

  draw(ctx: CanvasRenderingContext2D, camera: Camera, runs: RunData[], focus: number, t: number, layers: Layers, ratio: number): void {
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.clearRect(0, 0, ctx.canvas.width, ctx.canvas.height);
    camera.apply(ctx, ratio);
    this.drawCourse(ctx, camera.scale, layers);
    // The car looked at lies on top.
    const order = [...runs].sort((a, b) => Number(a.stack === focus) - Number(b.stack === focus));
    for (const run of order) {
      const own = run.stack === focus;
      const alpha = own || camera.mode !== "follow" ? 1 : 0.55;
      if (layers.trail) this.drawTrail(ctx, camera, run, t, alpha);
      if (layers.references && (own || camera.mode !== "follow")) this.drawReferences(ctx, camera, run, t);
      if (layers.plan && (own || camera.mode !== "follow")) this.drawPlan(ctx, camera, run, t);
      this.drawCar(ctx, camera, run, t, alpha, own);
      if (layers.forces && own && camera.scale * this.car.length > 24) this.drawForces(ctx, camera, run, t);
    }
  }

  private drawCourse(ctx: CanvasRenderingContext2D, scale: number, layers: Layers): void {
    if (this.surface) {
      ctx.fillStyle = token("asphalt");
      ctx.fill(this.surface, "evenodd");
    }
    ctx.strokeStyle = token("edge");
    ctx.lineWidth = 1.4 / scale;
    for (const edge of this.edges) ctx.stroke(edge);
    if (this.start) {
      ctx.lineWidth = 2.5 / scale;
      ctx.stroke(this.start);
    }
    if (layers.line && this.line) {
      ctx.lineWidth = 1 / scale;
      ctx.setLineDash([3 / scale, 5 / scale]);
      ctx.stroke(this.line);
      ctx.setLineDash([]);
    }
  }

  private drawTrail(ctx: CanvasRenderingContext2D, camera: Camera, run: RunData, t: number, alpha: number): void {
    const [xs, ys] = [run.channel("x"), run.channel("y")];
    if (!xs || !ys || !xs.length) return;
    const last = indexBefore(run.t, t);
    const pose = run.pose(t);
    ctx.strokeStyle = stackColour(run.stack);
    ctx.lineCap = "round";
    ctx.lineWidth = 2.2 / camera.scale;
    const seconds = 1.6;
    const pieces = 6;
    for (let piece = 0; piece < pieces; piece++) {
      const from = indexBefore(run.t, t - seconds * (1 - piece / pieces));
      const to = piece === pieces - 1 ? last : indexBefore(run.t, t - seconds * (1 - (piece + 1) / pieces));
      ctx.globalAlpha = (alpha * 0.7 * (piece + 1)) / pieces;
      ctx.beginPath();
      ctx.moveTo(xs[from], ys[from]);
      for (let i = from + 1; i <= to; i++) ctx.lineTo(xs[i], ys[i]);
      if (piece === pieces - 1) ctx.lineTo(pose.x, pose.y);
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }

  private drawPlan(ctx: CanvasRenderingContext2D, camera: Camera, run: RunData, t: number): void {
    const points = run.ahead("plan", t);
    if (!points.length || t > run.end) return;
    const pose = run.pose(t);
    ctx.strokeStyle = stackColour(run.stack);
    ctx.fillStyle = stackColour(run.stack);
    ctx.lineWidth = 1.6 / camera.scale;
    ctx.beginPath();
    ctx.moveTo(pose.x, pose.y);
    for (let i = 0; i < points.length; i += 2) ctx.lineTo(points[i], points[i + 1]);
    ctx.stroke();
    for (let i = 0; i < points.length; i += 2) {
      ctx.beginPath();
      ctx.arc(points[i], points[i + 1], 2.2 / camera.scale, 0, 2 * Math.PI);
      ctx.fill();
    }
  }

  private drawReferences(ctx: CanvasRenderingContext2D, camera: Camera, run: RunData, t: number): void {
    const points = run.ahead("ref", t);
    if (t > run.end) return;
    ctx.strokeStyle = token("ink");
    ctx.globalAlpha = 0.55;
    ctx.lineWidth = 1.1 / camera.scale;
    for (let i = 0; i < points.length; i += 2) {
      ctx.beginPath();
      ctx.arc(points[i], points[i + 1], 3.4 / camera.scale, 0, 2 * Math.PI);
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }

  private drawCar(ctx: CanvasRenderingContext2D, camera: Camera, run: RunData, t: number, alpha: number, own: boolean): void {
    const pose = run.pose(t);
    if (!Number.isFinite(pose.x) || !Number.isFinite(pose.y)) return;
    const { car } = this;
    // Far away the outline is enlarged so that it can be seen.
    const grow = Math.max(1, 19 / (car.length * camera.scale));
    const [length, width] = [car.length * grow, car.width * grow];
    const pixel = 1 / camera.scale;
    ctx.save();
    ctx.translate(pose.x, pose.y);
    ctx.rotate(pose.yaw);
    ctx.globalAlpha = pose.driving ? alpha : 0.35 * alpha;
    if (run.held("outside", t) >= 0.5) {
      ctx.strokeStyle = token("alarm");
      ctx.lineWidth = 3 * pixel;
      ctx.beginPath();
      ctx.arc(0, 0, length * 0.85, 0, 2 * Math.PI);
      ctx.stroke();
    }
    ctx.fillStyle = token("tyre");
    const steer = run.value("delta", t) || 0;
    const [wheelLength, wheelWidth] = [length * 0.2, width * 0.2];
    for (const [x, turn] of [
      [car.lf * grow, steer],
      [-car.lr * grow, 0],
    ])
      for (const side of [-1, 1]) {
        ctx.save();
        ctx.translate(Math.min(Math.max(x, -length * 0.36), length * 0.36), side * width * 0.46);
        ctx.rotate(turn);
        ctx.fillRect(-wheelLength / 2, -wheelWidth / 2, wheelLength, wheelWidth);
        ctx.restore();
      }
    ctx.fillStyle = stackColour(run.stack);
    ctx.strokeStyle = own ? token("ink") : token("surface");
    ctx.lineWidth = (own ? 1.8 : 1.2) * pixel;
    ctx.beginPath();
    ctx.moveTo(-length / 2, -width * 0.42);
    ctx.lineTo(length * 0.2, -width * 0.42);
    ctx.quadraticCurveTo(length * 0.52, -width * 0.3, length / 2, 0);
    ctx.quadraticCurveTo(length * 0.52, width * 0.3, length * 0.2, width * 0.42);
    ctx.lineTo(-length / 2, width * 0.42);
    ctx.closePath();
    ctx.fill();
    ctx.stroke();
    // Its marker on the roof, upright: no colour is needed to tell cars apart.
    ctx.rotate(-pose.yaw);
    ctx.scale(pixel, -pixel);
    drawMarker(new CanvasPen(ctx), stackShape(run.stack), 0, 0, (0.27 * width) / pixel, token("surface"), ctx.globalAlpha);
    ctx.restore();
    ctx.globalAlpha = 1;
  }

  // Lateral forces stand on their axles, the net force along the car on the rear one; the circle is what friction would allow the axle: mu times its static load. One car length is
  // one static axle load.
  private drawForces(ctx: CanvasRenderingContext2D, camera: Camera, run: RunData, t: number): void {
    const { car } = this;
    const pose = run.pose(t);
    const front = run.replayValue("force_front_n", t);
    const rear = run.replayValue("force_rear_n", t);
    const drive = car.mass * run.value("ax", t);
    if (!Number.isFinite(front) || !Number.isFinite(rear)) return;
    const weight = car.mass * 9.81 || 2 * Math.max(Math.abs(front), Math.abs(rear));
    const share = car.lr / (car.lf + car.lr);
    const mu = run.value("mu_true", t);
    const pixel = 1 / camera.scale;
    const steer = run.value("delta", t) || 0;
    const unit = car.length;
    ctx.save();
    ctx.translate(pose.x, pose.y);
    ctx.rotate(pose.yaw);
    const axles = [
      { x: car.lf, force: front, along: 0, load: share * weight, turn: steer, slip: run.replayValue("slip_front_rad", t) },
      { x: -car.lr, force: rear, along: Number.isFinite(drive) ? drive : 0, load: (1 - share) * weight, turn: 0, slip: run.replayValue("slip_rear_rad", t) },
    ];
    for (const { x, force, along, load, turn, slip } of axles) {
      ctx.save();
      ctx.translate(x, 0);
      ctx.rotate(turn);
      if (Number.isFinite(mu)) {
        ctx.strokeStyle = token("muted");
        ctx.lineWidth = pixel;
        ctx.setLineDash([3 * pixel, 3 * pixel]);
        ctx.beginPath();
        ctx.arc(0, 0, mu * unit, 0, 2 * Math.PI);
        ctx.stroke();
        ctx.setLineDash([]);
      }
      arrow(ctx, (along / load) * unit, (force / load) * unit, pixel, token("ink"));
      ctx.restore();
      if (Number.isFinite(slip)) this.label(ctx, `${(slip * 57.2958).toFixed(1).replace("-", "−")}°`, x, -unit * 1.25, pixel, pose.yaw);
    }
    ctx.restore();
  }

  private label(ctx: CanvasRenderingContext2D, text: string, x: number, y: number, pixel: number, yaw: number): void {
    ctx.save();
    ctx.translate(x, y);
    ctx.rotate(-yaw);
    ctx.scale(pixel, -pixel);
    ctx.fillStyle = token("muted");
    ctx.font = `11px ${fontFamily}`;
    ctx.textAlign = "center";
    ctx.fillText(text, 0, 4);
    ctx.restore();
  }
}

function arrow(ctx: CanvasRenderingContext2D, x: number, y: number, pixel: number, color: string): void {
  const length = Math.hypot(x, y);
  if (!(length > 3 * pixel)) return;
  const head = Math.min(7 * pixel, length / 2);
  const angle = Math.atan2(y, x);
  ctx.strokeStyle = color;
  ctx.fillStyle = color;
  ctx.lineWidth = 2.4 * pixel;
  ctx.beginPath();
  ctx.moveTo(0, 0);
  ctx.lineTo(x - head * Math.cos(angle), y - head * Math.sin(angle));
  ctx.stroke();
  ctx.beginPath();
  ctx.moveTo(x, y);
  for (const turn of [2.6, -2.6]) ctx.lineTo(x + head * 1.3 * Math.cos(angle + turn), y + head * 1.3 * Math.sin(angle + turn));
  ctx.fill();
}
