'use strict';

const $ = (id) => document.getElementById(id);

// A number as people write it: four digits, no noise.
function figure(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  if (value !== 0 && (Math.abs(value) >= 1e6 || Math.abs(value) < 1e-3)) return value.toExponential(2);
  return String(Number(value.toPrecision(digits)));
}
// An element with what is in it.
function make(tag, kind = '', children = []) {
  const element = document.createElement(tag);
  element.className = kind;
  element.append(...children);
  return element;
}
const many = (count) => count.toLocaleString('en-US');
const counted = (count, noun) => `${many(count)} ${noun}${count === 1 ? '' : 's'}`;

// What is chosen; `page.render` shows it.
const state = {
  tool: 'look',
  mark: 'coping',
  part: 'solid',
  mid: 'sheets',
  cut: 'off',
  flip: false,
  theme: 'dark',
  sheet: null,
};

// Milliseconds from which a frame is slow, and after which a view that does not move rests.
const SLOW = 60;
const RESTS = 250;

const page = {
  scene: null,
  // Whether frames are slow, the view last drawn, and when it rests.
  slow: false,
  version: -1,
  rest: 0,
  camera: new Camera(),
  // Facts and arrays of the part and of the mid-surface.
  part: null,
  mid: null,
  tagging: null,
  served: false,
  marks: null,
  pins: [],
  spot: null,
  wanted: false,

  render() {
    if (page.wanted) return;
    page.wanted = true;
    requestAnimationFrame(() => {
      page.wanted = false;
      page.draw();
    });
  },

  look() {
    return {
      part: state.part,
      mid: page.mid ? state.mid : 'hidden',
      lines: $('lines').checked,
      wire: $('wire').checked,
      plane: page.plane(),
      range: page.range,
      standing: state.sheet !== null,
      colors: page.colors,
    };
  },

  // While the view moves and frames take long, less is drawn; all again once it rests.
  draw() {
    if (!page.scene || !page.part) return;
    const moved = page.camera.version !== page.version;
    page.version = page.camera.version;
    const quick = moved && page.slow;
    const begun = performance.now();
    const { both } = page.scene.draw(page.camera, { ...page.look(), quick });
    if (moved && !page.slow && page.scene.drawn >= QUICK_FROM) {
      page.scene.finish();
      page.slow = performance.now() - begun > SLOW;
    }
    clearTimeout(page.rest);
    if (quick) page.rest = setTimeout(page.render, RESTS);
    page.both = both;
    page.drawAxes();
    for (const pin of page.pins) page.stick(pin.element, pin.at);
    if (page.spot) page.stick($('marker'), page.spot);
  },

  // Puts an element over a place of the part.
  stick(element, at) {
    const canvas = page.scene.canvas;
    const p = project(page.both, at);
    element.hidden = !p.before || Math.abs(p.x) > 1 || Math.abs(p.y) > 1;
    element.style.left = `${((p.x + 1) / 2) * canvas.clientWidth}px`;
    element.style.top = `${((1 - p.y) / 2) * canvas.clientHeight}px`;
  },

  drawAxes() {
    const { right, up, back } = page.camera;
    const axes = [['x', [1, 0, 0], '#e07b39'], ['y', [0, 1, 0], '#2fae85'], ['z', [0, 0, 1], '#4a9fe0']].map(
      ([name, axis, color]) => ({ name, color, x: 32 * dot(axis, right), y: -32 * dot(axis, up), z: dot(axis, back) }),
    );
    axes.sort((a, b) => a.z - b.z);
    $('axes').innerHTML = axes.map(({ name, color, x, y }) => `<line x1="0" y1="0" x2="${x}" y2="${y}" stroke="${color}"/>`
      + `<text x="${x * 1.32}" y="${y * 1.32}">${name}</text>`).join('');
  },

  // The section plane as normal and offset; what lies beyond is not drawn.
  plane() {
    const axis = 'xyz'.indexOf(state.cut);
    if (axis < 0) return null;
    const size = page.part.facts.size[axis];
    const at = (Number($('cut').value) - 0.5) * size * 1.001;
    const normal = [0, 0, 0];
    normal[axis] = state.flip ? -1 : 1;
    return [...normal, state.flip ? -at : at];
  },

  // Coordinates as the file has them.
  inFile(p) {
    return add(p, page.part.facts.origin);
  },

  say(text, bad = false, seconds = 5) {
    const box = $('message');
    box.textContent = text;
    box.className = bad ? 'bad' : '';
    box.hidden = false;
    clearTimeout(page.quiet);
    page.quiet = setTimeout(() => { box.hidden = true; }, 1000 * (bad ? 2 : 1) * seconds);
  },

  setTheme(theme) {
    state.theme = theme;
    document.documentElement.dataset.theme = theme;
    page.colors = colorsOf(theme);
    page.showLegend();
    page.render();
  },

  fit() {
    const canvas = page.scene.canvas;
    const aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight);
    page.camera.fit([0, 0, 0], page.part.facts.diagonal / 2 || 1, aspect);
    page.render();
  },

  // Brings a place into the middle, from where the view is, near enough to see `size`.
  fly(at, size) {
    page.spot = at;
    const from = { target: page.camera.target, distance: page.camera.distance };
    const near = Math.max(size, page.camera.radius * 0.02) / Math.sin(HALF_ANGLE);
    const to = Math.min(from.distance, near);
    const start = performance.now();
    const move = (now) => {
      const t = Math.min(1, Math.max(0, now - start) / 250);
      const s = t * t * (3 - 2 * t);
      page.camera.target = add(times(from.target, 1 - s), times(at, s));
      page.camera.distance = from.distance * (to / from.distance) ** s;
      page.camera.version++;
      page.render();
      if (t < 1) requestAnimationFrame(move);
    };
    requestAnimationFrame(move);
  },

  sendMarks(range = [0, page.tagging.count - 1]) {
    if (range) page.scene.mark(page.scene.part, page.tagging.marks, ...range);
    page.render();
  },

  // Shows all that hangs on the state in the panel.
  update() {
    const check = (name) => {
      for (const button of document.querySelectorAll(`[data-${name}]`)) {
        button.setAttribute('role', 'radio');
        button.setAttribute('aria-checked', String(button.dataset[name] === state[name]));
      }
    };
    ['tool', 'mark', 'part', 'mid', 'cut'].forEach(check);
    const canvas = page.scene.canvas;
    canvas.classList.toggle('tagging', state.tool !== 'look');
    $('tool-options').hidden = state.tool === 'look';
    for (const label of document.querySelectorAll('[data-for]')) label.hidden = label.dataset.for !== state.tool;
    $('cut-label').hidden = state.cut === 'off';
    if (state.cut !== 'off') {
      const [x, y, z, at] = page.plane();
      const axis = 'xyz'.indexOf(state.cut);
      $('cut-out').value = figure(at * (x + y + z) + page.part.facts.origin[axis]);
    }
    $('show-mid').hidden = !page.mid;
    $('angle-out').value = `${$('angle').value}°`;
    $('brush-out').value = `${$('brush').value} px`;
    document.querySelector('[data-do="perspective"]').setAttribute('aria-pressed', String(page.camera.perspective));
    page.showTags();
    page.showLegend();
    page.render();
  },

  showTags() {
    const tags = page.tagging;
    if (!tags) return;
    $('coping-count').textContent = tags.coping ? `${counted(tags.coping, 'triangle')}, area ${figure(tags.copingArea)}` : 'none yet';
    document.querySelector('[data-do="undo"]').disabled = !tags.done.length;
    document.querySelector('[data-do="redo"]').disabled = !tags.undone.length;
    document.querySelector('[data-do="clear"]').disabled = !tags.coping;
    document.querySelector('[data-do="save"]').disabled = !tags.changed;
    $('tag-file').textContent = tags.changed ? `Not saved yet: ${page.part.facts.tag_file}` : page.part.facts.tag_file;
    document.title = `${tags.changed ? '• ' : ''}${page.part.facts.title} – midsurf`;
  },

  showLegend() {
    const legend = $('legend');
    legend.hidden = !page.mid || state.mid === 'hidden';
    if (legend.hidden) return;
    const thickness = state.mid === 'thickness';
    $('legend-title').textContent = thickness ? 'Thickness' : counted(page.mid.facts.sheets.length, 'sheet');
    const rows = [];
    if (thickness) {
      const [low, high] = page.range;
      const bar = make('div', 'bar');
      bar.style.background = `linear-gradient(to top, ${RAMP.join(', ')})`;
      const ticks = [4, 3, 2, 1, 0].map((k) => make('span', '', [figure(low + ((high - low) * k) / 4, 3)]));
      rows.push(make('div', 'scale', [bar, make('div', 'ticks', ticks)]));
    }
    const kinds = new Set($('lines').checked ? page.mid.kinds : []);
    LINE_NAMES.forEach((name, k) => {
      if (!kinds.has(k)) return;
      const stroke = make('span', 'stroke');
      stroke.style.background = LINES[state.theme][k];
      rows.push(make('div', 'entry', [stroke, name]));
    });
    $('legend-body').replaceChildren(...rows);
  },
};
