// What part of the course the replay shows.
import type { Box } from "./mapview";

export type CameraMode = "fit" | "follow" | "free";

export class Camera {
  mode: CameraMode = "fit";
  /** Centre [m] and pixels per metre. */
  x = 0;
  y = 0;
  scale = 1;
  zoom = 1;
  private width = 1;
  private height = 1;

  constructor(private readonly box: Box) {}

  resize(width: number, height: number): void {
    this.width = width;
    this.height = height;
    if (this.mode === "fit") this.fit();
  }
  get fitScale(): number {
    const margin = 26;
    const { left, right, bottom, top } = this.box;
    return Math.min((this.width - 2 * margin) / Math.max(1e-6, right - left), (this.height - 2 * margin) / Math.max(1e-6, top - bottom));
  }
  fit(): void {
    this.mode = "fit";
    this.zoom = 1;
    this.scale = this.fitScale;
    this.x = (this.box.left + this.box.right) / 2;
    this.y = (this.box.bottom + this.box.top) / 2;
  }
  /** Looks at a car so that it is about `pixels` long. */
  follow(x: number, y: number, carLength: number, pixels: number): void {
    this.mode = "follow";
    this.scale = Math.max(this.fitScale, pixels / Math.max(carLength, 1e-6)) * this.zoom;
    this.x = x;
    this.y = y;
  }
  zoomBy(factor: number): void {
    if (this.mode === "fit") this.mode = "free";
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.2), 40);
    if (this.mode === "free") this.scale = Math.min(Math.max(this.scale * factor, this.fitScale * 0.5), this.fitScale * 60);
  }
  pan(dx: number, dy: number): void {
    this.mode = "free";
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
  }
  px(x: number): number {
    return this.width / 2 + (x - this.x) * this.scale;
  }
  py(y: number): number {
    return this.height / 2 - (y - this.y) * this.scale;
  }
  /** World coordinates from here on; `ratio` is the canvas' pixels per CSS pixel. */
  apply(ctx: CanvasRenderingContext2D, ratio: number): void {
    const k = this.scale * ratio;
    ctx.setTransform(k, 0, 0, -k, (this.width / 2) * ratio - this.x * k, (this.height / 2) * ratio + this.y * k);
  }
}
