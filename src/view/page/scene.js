'use strict';

const ROW = 2048;
// Ids of mid-surface triangles start here; a part has at most 2^31 triangles.
const MID_BIAS = 0x80000000;
const NO_PLANE = [0, 0, 0, 1];
// While the view moves where frames take long, a mesh of more triangles than this is drawn as if its
// vertices were those nearest to so many places along each side of its box.
const QUICK_FROM = 100000;
const QUICK_PLACES = 96;

// Facts and arrays of a pack; the layout is described where packs are written.
function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const types = { f32: Float32Array, u32: Uint32Array, u8: Uint8Array };
  const pack = { facts: header.facts };
  for (const [name, array] of Object.entries(header.arrays)) {
    pack[name] = new types[array.type](buffer, 4 + length + array.start, array.length);
  }
  return pack;
}

// What is drawn and picked. Knows nothing of the page but its canvas.
class Scene {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext('webgl2', { antialias: true, alpha: false, powerPreference: 'high-performance' });
    if (!gl) throw new Error('This page needs WebGL 2, which the browser does not offer here.');
    this.gl = gl;
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    this.faces = program(gl, FACE_VERTEX, FACE_FRAGMENT);
    this.picks = program(gl, PICK_VERTEX, PICK_FRAGMENT);
    this.strips = program(gl, LINE_VERTEX, LINE_FRAGMENT);
    this.bare = gl.createVertexArray();
    this.part = null;
    this.mid = null;
    this.lines = null;
    this.feet = null;
    this.pickKey = '';
  }

  setPart(pack) {
    this.part = this.mesh(pack.positions, null, pack.triangles);
  }

  setMid(pack) {
    this.release(this.mid);
    this.mid = this.mesh(pack.positions, pack.thickness, pack.triangles);
    const count = pack.kinds.length;
    const data = new Float32Array(7 * count);
    for (let n = 0; n < count; n++) {
      for (let k = 0; k < 2; k++) {
        const v = 3 * pack.lines[2 * n + k];
        data.set(pack.positions.subarray(v, v + 3), 7 * n + 3 * k);
      }
      data[7 * n + 6] = pack.kinds[n];
    }
    this.lines = this.segments(data, this.lines);
    this.pickKey = '';
  }

  // Points, corners and marks as textures.
  mesh(positions, values, triangles) {
    const gl = this.gl;
    const points = positions.length / 3;
    const four = new Float32Array(4 * padded(points));
    for (let n = 0; n < points; n++) {
      four[4 * n] = positions[3 * n];
      four[4 * n + 1] = positions[3 * n + 1];
      four[4 * n + 2] = positions[3 * n + 2];
      if (values) four[4 * n + 3] = values[n];
    }
    return {
      source: { positions, triangles },
      points: texture(gl, gl.RGBA32F, gl.RGBA, gl.FLOAT, four, 4),
      ...this.faced(triangles),
    };
  }

  // Corners of triangles, and marks that are not set yet.
  faced(triangles) {
    const gl = this.gl;
    const count = triangles.length / 3;
    const corners = new Uint32Array(3 * padded(count));
    corners.set(triangles);
    return {
      count,
      corners: texture(gl, gl.RGB32UI, gl.RGB_INTEGER, gl.UNSIGNED_INT, corners, 3),
      marks: texture(gl, gl.R8UI, gl.RED_INTEGER, gl.UNSIGNED_BYTE, new Uint8Array(padded(count)), 1),
    };
  }

  release(mesh) {
    if (!mesh) return;
    for (const each of [mesh.points, mesh.corners, mesh.marks]) this.gl.deleteTexture(each);
    if (mesh.quick) for (const each of [mesh.quick.corners, mesh.quick.marks]) this.gl.deleteTexture(each);
  }

  // The mesh with vertices near each other as one: a few ten thousand triangles, drawn while the view moves.
  quickened(mesh) {
    if (mesh.count < QUICK_FROM) return mesh;
    if (!mesh.quick) {
      const { corners, of } = clustered(mesh.source.positions, mesh.source.triangles);
      mesh.quick = { points: mesh.points, of, ...this.faced(corners) };
    }
    if (mesh.marked) {
      const marks = new Uint8Array(padded(mesh.quick.count));
      mesh.quick.of.forEach((triangle, n) => { marks[n] = mesh.marked[triangle]; });
      this.mark(mesh.quick, marks);
      mesh.marked = null;
    }
    return mesh.quick;
  }

  // Waits for what was drawn.
  finish() {
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  // Sends the marks of the triangles from `first` to `last` in whole rows. `marks` fills whole rows.
  mark(mesh, marks, first = 0, last = mesh.count - 1) {
    const gl = this.gl;
    const top = Math.floor(first / ROW);
    const rows = Math.floor(last / ROW) - top + 1;
    mesh.marked = marks;
    gl.bindTexture(gl.TEXTURE_2D, mesh.marks);
    const part = marks.subarray(top * ROW, (top + rows) * ROW);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, top, ROW, rows, gl.RED_INTEGER, gl.UNSIGNED_BYTE, part);
  }

  segments(data, old) {
    const gl = this.gl;
    const lines = old || { array: gl.createVertexArray(), buffer: gl.createBuffer() };
    gl.bindVertexArray(lines.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, lines.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
    for (const [index, size, offset] of [[0, 3, 0], [1, 3, 12], [2, 1, 24]]) {
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, size, gl.FLOAT, false, 28, offset);
      gl.vertexAttribDivisor(index, 1);
    }
    gl.bindVertexArray(null);
    lines.count = data.length / 7;
    return lines;
  }

  // A few segments over everything, as [from, to, kind].
  overlay(list) {
    const data = new Float32Array(list.flatMap(([from, to, kind]) => [...from, ...to, kind]));
    this.feet = this.segments(data, this.feet);
  }

  resize() {
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * scale));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * scale));
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
      this.pickKey = '';
    }
    this.scale = scale;
    return width / height;
  }

  // `look`: part ('solid', 'glass', 'hidden'), mid ('sheets', 'thickness', 'hidden'), lines, wire, plane, range,
  // standing (a sheet stands out), quick (as the view moves), and colours.
  draw(camera, look) {
    const gl = this.gl;
    const aspect = this.resize();
    const matrices = camera.matrices(aspect);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...look.colors.ground, 1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.disable(gl.BLEND);
    const [part, mid] = [this.part, this.mid].map((mesh) => (mesh && look.quick ? this.quickened(mesh) : mesh));
    this.drawn = 0;
    if (part && look.part === 'solid') this.drawFaces(part, 0, matrices, look);
    if (mid && look.mid !== 'hidden') {
      this.drawFaces(mid, look.mid === 'sheets' ? 1 : 2, matrices, look);
    }
    if (this.lines && look.lines && look.mid !== 'hidden') this.drawLines(this.lines, matrices, look, 1e-3, true);
    if (part && look.part === 'glass') {
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      gl.depthMask(false);
      this.drawFaces(part, 0, matrices, look);
      gl.depthMask(true);
      gl.disable(gl.BLEND);
    }
    if (this.feet && this.feet.count) this.drawLines(this.feet, matrices, look, 0, false);
    return matrices;
  }

  bind(mesh, use, both) {
    const gl = this.gl;
    gl.useProgram(use.program);
    gl.bindVertexArray(this.bare);
    ['points', 'corners', 'marks'].forEach((name, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, mesh[name]);
      gl.uniform1i(use.at(name), unit);
    });
    gl.uniformMatrix4fv(use.at('both'), false, both);
  }

  drawFaces(mesh, what, matrices, look) {
    const gl = this.gl;
    const use = this.faces;
    this.bind(mesh, use, matrices.both);
    gl.uniformMatrix4fv(use.at('view'), false, matrices.view);
    gl.uniform4fv(use.at('plane'), look.plane || NO_PLANE);
    gl.uniform1i(use.at('what'), what);
    gl.uniform1f(use.at('glass'), look.part === 'glass' ? 1 : 0);
    gl.uniform1f(use.at('wire'), look.wire ? 0.55 : 0);
    gl.uniform1f(use.at('picked'), look.standing ? 1 : -1);
    gl.uniform3fv(use.at('palette'), look.colors.palette.flat());
    gl.uniform3fv(use.at('ramp'), look.colors.ramp.flat());
    gl.uniform2fv(use.at('range'), look.range || [0, 1]);
    gl.uniform3fv(use.at('tints'), look.colors.tints.flat());
    gl.drawArrays(gl.TRIANGLES, 0, 3 * mesh.count);
    this.drawn += mesh.count;
  }

  drawLines(lines, matrices, look, lift, depth) {
    const gl = this.gl;
    const use = this.strips;
    if (!depth) gl.disable(gl.DEPTH_TEST);
    gl.useProgram(use.program);
    gl.bindVertexArray(lines.array);
    gl.uniformMatrix4fv(use.at('both'), false, matrices.both);
    gl.uniform2f(use.at('screen'), this.canvas.width, this.canvas.height);
    gl.uniform1f(use.at('width'), 2.6 * this.scale);
    gl.uniform1f(use.at('lift'), lift);
    gl.uniform1fv(use.at('widths'), [1, 1, 1, 2.2]);
    gl.uniform3fv(use.at('colors'), (depth ? look.colors.lines : look.colors.overlay).flat());
    gl.uniform4fv(use.at('plane'), (depth && look.plane) || NO_PLANE);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, lines.count);
    gl.bindVertexArray(null);
    gl.enable(gl.DEPTH_TEST);
  }

  // Ids of what shows in a rectangle of CSS pixels, from a picture of ids that is drawn anew only when the
  // view has changed. `targets` lists 'part' and 'mid'.
  pick(camera, look, targets, x, y, width = 1, height = 1) {
    const gl = this.gl;
    const [w, h] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const key = [camera.version, camera.perspective, w, h, targets, look.plane].join();
    if (!this.idPicture || this.idPicture.w !== w || this.idPicture.h !== h) this.makeIdPicture(w, h);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.idPicture.frame);
    if (key !== this.pickKey) {
      const matrices = camera.matrices(w / h);
      gl.viewport(0, 0, w, h);
      gl.disable(gl.BLEND);
      gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
      gl.clearBufferfv(gl.DEPTH, 0, [1]);
      for (const [name, bias] of [['part', 0], ['mid', MID_BIAS]]) {
        if (!this[name] || !targets.includes(name)) continue;
        this.bind(this[name], this.picks, matrices.both);
        gl.uniform1ui(this.picks.at('bias'), bias);
        gl.uniform4fv(this.picks.at('plane'), look.plane || NO_PLANE);
        gl.drawArrays(gl.TRIANGLES, 0, 3 * this[name].count);
      }
      this.pickKey = key;
    }
    const left = Math.max(0, Math.floor(x));
    const top = Math.max(0, Math.floor(y));
    const across = Math.min(w, Math.ceil(x + width)) - left;
    const down = Math.min(h, Math.ceil(y + height)) - top;
    if (across <= 0 || down <= 0) return { ids: new Uint32Array(0), width: 0, height: 0 };
    const ids = new Uint32Array(4 * across * down);
    gl.readPixels(left, h - top - down, across, down, gl.RGBA_INTEGER, gl.UNSIGNED_INT, ids);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return { ids, width: across, height: down, left, top };
  }

  makeIdPicture(w, h) {
    const gl = this.gl;
    if (this.idPicture) {
      gl.deleteRenderbuffer(this.idPicture.color);
      gl.deleteRenderbuffer(this.idPicture.depth);
      gl.deleteFramebuffer(this.idPicture.frame);
    }
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    const buffer = (format, where) => {
      const made = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, made);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, w, h);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, where, gl.RENDERBUFFER, made);
      return made;
    };
    const color = buffer(gl.RGBA32UI, gl.COLOR_ATTACHMENT0);
    const depth = buffer(gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT);
    this.idPicture = { frame, color, depth, w, h };
    this.pickKey = '';
  }
}

const padded = (count) => Math.max(1, Math.ceil(count / ROW)) * ROW;

// Triangles between the first vertices of places of a grid, each once, and which triangle each was.
function clustered(positions, triangles) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let n = 0; n < positions.length; n++) {
    const k = n % 3;
    if (positions[n] < low[k]) low[k] = positions[n];
    if (positions[n] > high[k]) high[k] = positions[n];
  }
  const step = Math.max(...high.map((h, k) => h - low[k]), 1e-30) / QUICK_PLACES;
  const first = new Map();
  const places = new Uint32Array(positions.length / 3);
  const vertices = [];
  for (let v = 0; v < places.length; v++) {
    let key = 0;
    for (let k = 0; k < 3; k++) key = key * (QUICK_PLACES + 2) + Math.floor((positions[3 * v + k] - low[k]) / step);
    let place = first.get(key);
    if (place === undefined) {
      place = vertices.length;
      first.set(key, place);
      vertices.push(v);
    }
    places[v] = place;
  }
  const seen = new Set();
  const [corners, of] = [[], []];
  for (let t = 0; 3 * t < triangles.length; t++) {
    const [a, b, c] = [0, 1, 2].map((k) => places[triangles[3 * t + k]]);
    if (a === b || b === c || c === a) continue;
    const [x, y, z] = [a, b, c].sort((p, q) => p - q);
    const key = (x * vertices.length + y) * vertices.length + z;
    if (seen.has(key)) continue;
    seen.add(key);
    corners.push(vertices[a], vertices[b], vertices[c]);
    of.push(t);
  }
  return { corners, of };
}

function texture(gl, inside, format, type, data, channels) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  const height = data.length / channels / ROW;
  gl.texImage2D(gl.TEXTURE_2D, 0, inside, ROW, height, 0, format, type, data);
  for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
  return made;
}

function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) {
    const logs = gl.getAttachedShaders(made).map((shader) => gl.getShaderInfoLog(shader));
    throw new Error(`shaders: ${gl.getProgramInfoLog(made)} ${logs.join(' ')}`);
  }
  const places = new Map();
  const at = (name) => {
    if (!places.has(name)) places.set(name, gl.getUniformLocation(made, name));
    return places.get(name);
  };
  return { program: made, at };
}
