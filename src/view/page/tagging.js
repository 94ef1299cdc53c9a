'use strict';

const NO_TRIANGLE = 0xffffffff;
const COPING = 1;
const PREVIEW = 2;
const MOST_UNDONE = 200;

// Which triangles are coping, how they came to be so, and how to go back.
class Tagging {
  constructor(pack) {
    this.triangles = pack.triangles;
    this.positions = pack.positions;
    this.neighbours = pack.neighbours;
    this.facets = pack.facets || null;
    this.count = pack.coping.length;
    // Whole rows, as they are sent to be drawn.
    this.marks = new Uint8Array(padded(this.count));
    this.marks.set(pack.coping);
    this.normals = new Float32Array(3 * this.count);
    this.areas = new Float32Array(this.count);
    this.measure();
    this.done = [];
    this.undone = [];
    // What was detected is in no file yet.
    this.saved = pack.facts.tags_are_saved ? this.marks.slice(0, this.count) : new Uint8Array(this.count).fill(2);
    this.tally();
  }

  corner(triangle, k) {
    const v = 3 * this.triangles[3 * triangle + k];
    return [this.positions[v], this.positions[v + 1], this.positions[v + 2]];
  }

  measure() {
    for (let n = 0; n < this.count; n++) {
      const [a, b, c] = [0, 1, 2].map((k) => this.corner(n, k));
      const across = cross(sub(b, a), sub(c, a));
      this.areas[n] = norm(across) / 2;
      this.normals.set(unit(across), 3 * n);
    }
  }

  tally() {
    this.coping = 0;
    this.copingArea = 0;
    this.changed = false;
    for (let n = 0; n < this.count; n++) {
      const flag = this.marks[n] & COPING;
      if (flag) {
        this.coping++;
        this.copingArea += this.areas[n];
      }
      if (flag !== (this.saved[n] & 3)) this.changed = true;
    }
  }

  // A triangle and all that hang together with it over edges that bend by no more than `angle` degrees.
  grow(seed, angle) {
    const least = Math.cos((angle * Math.PI) / 180) - 1e-6;
    const seen = new Uint8Array(this.count);
    const found = [seed];
    seen[seed] = 1;
    const { normals, neighbours, facets, areas } = this;
    for (let next = 0; next < found.length; next++) {
      const n = found[next];
      for (let k = 0; k < 3; k++) {
        const other = neighbours[3 * n + k];
        if (other === NO_TRIANGLE || seen[other]) continue;
        const bend = normals[3 * n] * normals[3 * other] + normals[3 * n + 1] * normals[3 * other + 1]
          + normals[3 * n + 2] * normals[3 * other + 2];
        // A triangle without area has no direction to object to.
        const flat = bend >= least || areas[n] === 0 || areas[other] === 0 || (facets && facets[n] === facets[other]);
        if (flat) {
          seen[other] = 1;
          found.push(other);
        }
      }
    }
    return found;
  }

  // All triangles of the facets that some triangles belong to: a file tags facets.
  whole(list) {
    if (!this.facets) return list;
    const all = new Set();
    for (const n of list) {
      let first = n;
      while (first > 0 && this.facets[first - 1] === this.facets[n]) first--;
      for (let k = first; k < this.count && this.facets[k] === this.facets[n]; k++) all.add(k);
    }
    return [...all];
  }

  // Makes triangles coping or wall. Steps with the same `stroke` are undone as one.
  set(list, coping, stroke = null) {
    const flag = coping ? COPING : 0;
    const changed = this.whole(list).filter((n) => (this.marks[n] & COPING) !== flag);
    if (!changed.length) return false;
    for (const n of changed) this.flip(n);
    const last = this.done[this.done.length - 1];
    if (stroke !== null && last && last.stroke === stroke) last.list.push(...changed);
    else this.done.push({ list: changed, stroke });
    if (this.done.length > MOST_UNDONE) this.done.shift();
    this.undone = [];
    this.tally();
    return true;
  }

  flip(n) {
    this.marks[n] ^= COPING;
  }

  undo() {
    return this.step(this.done, this.undone);
  }

  redo() {
    return this.step(this.undone, this.done);
  }

  step(from, to) {
    const last = from.pop();
    if (!last) return false;
    last.stroke = null;
    for (const n of last.list) this.flip(n);
    to.push(last);
    this.tally();
    return true;
  }

  // Shows what a click would take; gives the range that changed.
  preview(list) {
    let [first, last] = [this.count, -1];
    const touch = (n) => {
      first = Math.min(first, n);
      last = Math.max(last, n);
    };
    for (const n of this.shownPreview || []) {
      this.marks[n] &= ~PREVIEW;
      touch(n);
    }
    for (const n of list) {
      this.marks[n] |= PREVIEW;
      touch(n);
    }
    this.shownPreview = list;
    return last < 0 ? null : [first, last];
  }

  // A byte a triangle, for the server.
  flags() {
    return this.marks.slice(0, this.count).map((mark) => mark & COPING);
  }

  markSaved() {
    this.saved = this.flags();
    this.tally();
  }
}
