'use strict';
// Vectors are arrays of three numbers; matrices are column by column, as WebGL takes them.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => times(a, 1 / (norm(a) || 1));

function multiply(a, b) {
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + row] * b[4 * column + k];
      out[4 * column + row] = sum;
    }
  }
  return out;
}

// Half the angle that the picture spans from bottom to top.
const HALF_ANGLE = (17 * Math.PI) / 180;
// Never quite overhead, lest left and right turn about.
const STEEPEST = (89.9 * Math.PI) / 180;

// A turntable: z stays up. `yaw` turns about z, `pitch` lifts; the target is in the middle of the picture.
class Camera {
  constructor() {
    this.target = [0, 0, 0];
    this.yaw = -0.9;
    this.pitch = 0.5;
    this.distance = 10;
    this.radius = 1;
    this.perspective = true;
    // Counts changes, for whoever keeps something that depends on the view.
    this.version = 0;
  }

  // From the target to the eye.
  get back() {
    const flat = Math.cos(this.pitch);
    return [flat * Math.cos(this.yaw), flat * Math.sin(this.yaw), Math.sin(this.pitch)];
  }
  get right() {
    return [-Math.sin(this.yaw), Math.cos(this.yaw), 0];
  }
  get up() {
    return cross(this.back, this.right);
  }
  get eye() {
    return add(this.target, times(this.back, this.distance));
  }
  // Half the height of the picture at the target, in part units.
  get halfHeight() {
    return this.distance * Math.tan(HALF_ANGLE);
  }

  turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.max(-STEEPEST, Math.min(STEEPEST, this.pitch + pitch));
    this.version++;
  }

  // Shifts by shares of half the picture's height.
  pan(x, y) {
    const step = add(times(this.right, -x * this.halfHeight), times(this.up, -y * this.halfHeight));
    this.target = add(this.target, step);
    this.version++;
  }

  // Zooms; the place that is `x`, `y` half heights off the middle stays where it is.
  zoom(factor, x = 0, y = 0) {
    const before = this.halfHeight;
    const least = this.radius * 1e-3;
    this.distance = Math.max(least, Math.min(this.radius * 60, this.distance * factor));
    const shift = before - this.halfHeight;
    this.target = add(this.target, add(times(this.right, x * shift), times(this.up, y * shift)));
    this.version++;
  }

  look(yaw, pitch) {
    this.yaw = yaw;
    this.pitch = pitch;
    this.turn(0, 0);
  }

  // All of a ball around `centre` in the picture.
  fit(centre, radius, aspect) {
    this.target = centre.slice();
    this.distance = radius / Math.sin(HALF_ANGLE) / Math.min(1, aspect);
    this.version++;
  }

  matrices(aspect) {
    const [r, u, b, e] = [this.right, this.up, this.back, this.eye];
    const view = new Float32Array([
      r[0], u[0], b[0], 0, r[1], u[1], b[1], 0, r[2], u[2], b[2], 0,
      -dot(r, e), -dot(u, e), -dot(b, e), 1,
    ]);
    // The part lies around the origin of the coordinates.
    const middle = dot(b, e);
    const reach = this.radius * 1.1;
    const far = Math.max(middle + reach, this.radius * 1e-3);
    const h = this.halfHeight;
    let projection;
    if (this.perspective) {
      const near = Math.max(middle - reach, far * 2e-4);
      const f = 1 / Math.tan(HALF_ANGLE);
      const depth = near - far;
      projection = new Float32Array([
        f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / depth, -1, 0, 0, (2 * far * near) / depth, 0,
      ]);
    } else {
      const near = middle - reach;
      const depth = near - far;
      projection = new Float32Array([
        1 / (h * aspect), 0, 0, 0, 0, 1 / h, 0, 0, 0, 0, 2 / depth, 0, 0, 0, (far + near) / depth, 1,
      ]);
    }
    return { view, projection, both: multiply(projection, view) };
  }
}

// Where a point shows: x and y from -1 to 1, and whether it is before the eye.
function project(both, p) {
  const row = (k) => both[k] * p[0] + both[4 + k] * p[1] + both[8 + k] * p[2] + both[12 + k];
  const w = row(3);
  return { x: row(0) / w, y: row(1) / w, before: w > 0 };
}
