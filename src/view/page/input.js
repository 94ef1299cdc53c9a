'use strict';
// Pointer and keys.

const VIEWS = {
  iso: [-0.9, 0.5], x: [0, 0], '-x': [Math.PI, 0], y: [Math.PI / 2, 0], '-y': [-Math.PI / 2, 0],
  z: [-Math.PI / 2, Math.PI / 2], '-z': [-Math.PI / 2, -Math.PI / 2],
};
// Below this many pixels a press with a little shake is a click.
const SHAKE = 4;

const input = {
  drag: null,
  stroke: 0,

  // What can be picked with the tool in hand.
  targets() {
    if (state.tool !== 'look' && page.tagging) return ['part'];
    const list = [];
    if (page.mid && state.mid !== 'hidden') list.push('mid');
    if (state.part === 'solid' || (state.part === 'glass' && !list.length)) list.push('part');
    return list;
  },

  pickAt(event) {
    const { ids } = page.scene.pick(page.camera, page.look(), input.targets(), event.offsetX, event.offsetY);
    if (!ids[0]) return null;
    const isMid = ids[0] >= MID_BIAS;
    const bits = new Float32Array(ids.buffer, 4, 2);
    return { isMid, triangle: (isMid ? ids[0] - MID_BIAS : ids[0]) - 1, value: bits[0], depth: bits[1] };
  },

  // The place under the pointer, from its depth in the picture of ids.
  placeOf(event, depth) {
    const canvas = page.scene.canvas;
    const [w, h] = [canvas.clientWidth, canvas.clientHeight];
    const { view, projection } = page.camera.matrices(w / h);
    const x = ((event.offsetX + 0.5) / w) * 2 - 1;
    const y = 1 - ((event.offsetY + 0.5) / h) * 2;
    const z = depth * 2 - 1;
    const p = projection;
    const away = page.camera.perspective ? -p[14] / (z + p[10]) : (z - p[14]) / p[10];
    const scale = page.camera.perspective ? -away : 1;
    const seen = [(x * scale) / p[0], (y * scale) / p[5], away];
    const { right, up, back, eye } = page.camera;
    return add(eye, add(times(right, seen[0]), add(times(up, seen[1]), times(back, seen[2]))));
  },

  // Coping or wall, turned about by a held key.
  marks(event) {
    return (state.mark === 'coping') !== event.altKey;
  },

  down(event) {
    const canvas = page.scene.canvas;
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    const left = event.button === 0;
    let kind = 'turn';
    if (!left || event.shiftKey) kind = 'pan';
    else if (state.tool === 'brush' && page.tagging) kind = 'brush';
    else if (state.tool === 'box' && page.tagging) kind = 'box';
    if (event.button === 2 && (state.tool === 'brush' || state.tool === 'box')) kind = event.shiftKey ? 'pan' : 'turn';
    input.drag = { kind, x: event.offsetX, y: event.offsetY, moved: 0, left };
    input.stroke++;
    $('tip').hidden = true;
    if (kind === 'brush') input.paint(event);
    if (kind === 'turn' || kind === 'pan') canvas.classList.add('turning');
  },

  move(event) {
    const drag = input.drag;
    if (!drag) {
      input.latest = event;
      if (!input.hovering) {
        input.hovering = true;
        requestAnimationFrame(() => {
          input.hovering = false;
          if (!input.drag) input.hover(input.latest);
        });
      }
      return;
    }
    const [dx, dy] = [event.offsetX - drag.x, event.offsetY - drag.y];
    drag.moved = Math.max(drag.moved, Math.hypot(dx, dy));
    const height = page.scene.canvas.clientHeight;
    if (drag.kind === 'box') return input.showRubber(event);
    if (drag.kind === 'brush') {
      input.moveRing(event);
      input.paint(event);
    } else if (drag.moved > SHAKE) {
      if (drag.kind === 'turn') page.camera.turn((-dx / height) * 4, (dy / height) * 4);
      else page.camera.pan((2 * dx) / height, (-2 * dy) / height);
    } else return;
    drag.x = event.offsetX;
    drag.y = event.offsetY;
    page.render();
  },

  up(event) {
    const drag = input.drag;
    input.drag = null;
    page.scene.canvas.classList.remove('turning');
    if (!drag) return;
    if (drag.kind === 'box') input.takeBox(event, drag);
    else if (drag.left && drag.moved <= SHAKE && drag.kind !== 'brush') input.click(event);
  },

  click(event) {
    const hit = input.pickAt(event);
    if (state.tool === 'face' && page.tagging) {
      if (!hit) return;
      const list = page.tagging.grow(hit.triangle, Number($('angle').value));
      page.tagging.preview([]);
      input.tag(list, input.marks(event));
      return;
    }
    if (state.tool !== 'look') return;
    if (!hit) return clearPins() || page.render();
    const at = input.placeOf(event, hit.depth);
    pin(at, hit.isMid ? `t ${figure(hit.value)}` : page.inFile(at).map((value) => figure(value)).join(', '));
  },

  tag(list, coping, stroke = null) {
    page.tagging.set(list, coping, stroke);
    page.sendMarks();
    page.update();
  },

  hover(event) {
    if (!page.part) return;
    input.moveRing(event);
    const tip = $('tip');
    const hit = event.buttons || event.type === 'pointerleave' ? null : input.pickAt(event);
    if (state.tool === 'face' && page.tagging) {
      const shown = page.tagging.shownPreview;
      const same = hit && shown && page.tagging.marks[hit.triangle] & PREVIEW && input.grownBy === $('angle').value;
      if (!same && !page.doubt) {
        input.grownBy = $('angle').value;
        const list = hit ? page.tagging.grow(hit.triangle, Number(input.grownBy)) : [];
        const range = page.tagging.preview(list);
        if (range) page.sendMarks(range);
      }
    }
    let text = '';
    let feet = [];
    if (hit && hit.isMid) {
      const at = input.placeOf(event, hit.depth);
      text = `thickness ${figure(hit.value)}\nsheet ${page.mid.sheets[hit.triangle]}`;
      feet = input.feetAt(hit.triangle, at);
    } else if (hit && state.tool === 'look') {
      const at = page.inFile(input.placeOf(event, hit.depth));
      const facet = page.tagging && page.tagging.facets ? page.tagging.facets[hit.triangle] : hit.triangle;
      text = `${at.map((value) => figure(value)).join(', ')}\ntriangle ${facet}`;
      if (page.served) input.askThickness(hit.triangle, at, text);
    }
    page.scene.overlay(feet);
    tip.hidden = !text;
    tip.textContent = text;
    const canvas = page.scene.canvas;
    tip.style.left = `${Math.min(event.offsetX + 16, canvas.clientWidth - 190)}px`;
    tip.style.top = `${Math.min(event.offsetY + 16, canvas.clientHeight - 52)}px`;
    page.render();
  },

  // Wall thickness under the pointer, from the server; one question at a time.
  async askThickness(triangle, at, text) {
    input.wanted = { triangle, at, text };
    if (input.asking) return;
    input.asking = true;
    while (input.wanted) {
      const { triangle: n, at: p, text: shown } = input.wanted;
      input.wanted = null;
      try {
        const { thickness } = await (await fetch(`thickness?${n},${p.join(',')}`)).json();
        const tip = $('tip');
        if (thickness && tip.textContent === shown) tip.textContent = `thickness ${figure(thickness)}\n${shown}`;
      } catch {
        // The page says elsewhere that the server went away.
      }
    }
    input.asking = false;
  },

  // From wall to wall through the vertex nearest to the pointer.
  feetAt(triangle, at) {
    const { triangles, positions, feet } = page.mid;
    let [best, least] = [0, Infinity];
    for (let k = 0; k < 3; k++) {
      const v = triangles[3 * triangle + k];
      const far = norm(sub([positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]], at));
      if (far < least) [best, least] = [v, far];
    }
    const point = (array, n) => [array[3 * n], array[3 * n + 1], array[3 * n + 2]];
    const middle = point(positions, best);
    return [0, 1].map((k) => [middle, point(feet, 2 * best + k), 0]);
  },

  moveRing(event) {
    const ring = $('ring');
    ring.hidden = state.tool !== 'brush' || !page.tagging;
    const size = 2 * Number($('brush').value);
    ring.style.width = ring.style.height = `${size}px`;
    ring.style.left = `${event.offsetX}px`;
    ring.style.top = `${event.offsetY}px`;
  },

  // Triangles that show under the brush.
  paint(event) {
    const r = Number($('brush').value);
    const found = page.scene.pick(page.camera, page.look(), ['part'], event.offsetX - r, event.offsetY - r, 2 * r, 2 * r);
    const list = new Set();
    for (let row = 0; row < found.height; row++) {
      for (let column = 0; column < found.width; column++) {
        const id = found.ids[4 * (row * found.width + column)];
        const x = found.left + column + 0.5 - event.offsetX;
        const y = found.top + (found.height - 1 - row) + 0.5 - event.offsetY;
        if (id && x * x + y * y <= r * r) list.add(id - 1);
      }
    }
    if (list.size) input.tag([...list], input.marks(event), input.stroke);
  },

  showRubber(event) {
    const { x, y } = input.drag;
    const rubber = $('rubber');
    rubber.hidden = false;
    rubber.style.left = `${Math.min(x, event.offsetX)}px`;
    rubber.style.top = `${Math.min(y, event.offsetY)}px`;
    rubber.style.width = `${Math.abs(event.offsetX - x)}px`;
    rubber.style.height = `${Math.abs(event.offsetY - y)}px`;
  },

  // Triangles in the rectangle: those that show with most of themselves in it, or all whose corners are.
  takeBox(event, { x, y, moved }) {
    $('rubber').hidden = true;
    if (moved <= SHAKE) return;
    const [left, right] = [Math.min(x, event.offsetX), Math.max(x, event.offsetX)];
    const [top, bottom] = [Math.min(y, event.offsetY), Math.max(y, event.offsetY)];
    const canvas = page.scene.canvas;
    const [w, h] = [canvas.clientWidth, canvas.clientHeight];
    const { both } = page.camera.matrices(w / h);
    const { positions, triangles } = page.part;
    const inside = new Uint8Array(positions.length / 3);
    for (let v = 0; v < inside.length; v++) {
      const p = project(both, [positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]]);
      const [px, py] = [((p.x + 1) / 2) * w, ((1 - p.y) / 2) * h];
      inside[v] = p.before && px >= left && px <= right && py >= top && py <= bottom ? 1 : 0;
    }
    const all = (n) => inside[triangles[3 * n]] && inside[triangles[3 * n + 1]] && inside[triangles[3 * n + 2]];
    const list = [];
    if ($('through').checked) {
      for (let n = 0; n < page.tagging.count; n++) if (all(n)) list.push(n);
    } else {
      const found = page.scene.pick(page.camera, page.look(), ['part'], left, top, right - left, bottom - top);
      const seen = new Set();
      for (let k = 0; k < found.ids.length; k += 4) if (found.ids[k]) seen.add(found.ids[k] - 1);
      for (const n of seen) if (all(n)) list.push(n);
    }
    if (list.length) input.tag(list, input.marks(event));
    else page.say('No whole triangle in the box', false, 2);
  },

  wheel(event) {
    event.preventDefault();
    const canvas = page.scene.canvas;
    const half = canvas.clientHeight / 2;
    const [x, y] = [(event.offsetX - canvas.clientWidth / 2) / half, (half - event.offsetY) / half];
    const lines = event.deltaMode === 1 ? 30 : 1;
    page.camera.zoom(Math.exp(Math.max(-120, Math.min(120, event.deltaY * lines)) * 0.0022), x, y);
    page.render();
  },

  actions: {
    fit: () => page.fit(),
    closer: () => page.camera.zoom(0.8),
    farther: () => page.camera.zoom(1.25),
    perspective() {
      page.camera.perspective = !page.camera.perspective;
      page.camera.version++;
    },
    screenshot: () => work.screenshot(),
    theme: () => page.setTheme(state.theme === 'dark' ? 'light' : 'dark'),
    help: () => $('help').showModal(),
    undo: () => page.tagging && page.tagging.undo() && page.sendMarks(),
    redo: () => page.tagging && page.tagging.redo() && page.sendMarks(),
    clear() {
      input.tag([...Array(page.tagging.count).keys()], false);
    },
    save: () => work.save(),
    extract: () => work.extract(),
    cancel: () => work.cancel(),
    flip: () => { state.flip = !state.flip; },
  },

  act(name) {
    if (name.startsWith('view-')) page.camera.look(...VIEWS[name.slice(5)]);
    else input.actions[name]();
    page.update();
  },

  next(key, order) {
    state[key] = order[(order.indexOf(state[key]) + 1) % order.length];
    page.update();
  },

  tool(name) {
    if (!page.tagging) return;
    state.tool = name;
    // What is hidden or cannot be told apart cannot be tagged.
    if (name !== 'look' && state.part === 'hidden') state.part = 'glass';
    const range = page.tagging.preview([]);
    if (range) page.sendMarks(range);
    $('ring').hidden = true;
    page.update();
  },

  escape() {
    if (work.running) return work.cancel();
    if (page.doubt) page.sendMarks(page.tagging.preview([]));
    page.doubt = null;
    page.spot = null;
    $('marker').hidden = true;
    $('message').hidden = true;
    clearPins();
    if (state.sheet !== null) {
      state.sheet = null;
      markSheets();
    }
    input.tool('look');
    page.render();
  },

  // One key, one deed; what is held with Ctrl stands apart.
  keys: {
    f: () => input.act('fit'),
    0: () => input.act('view-iso'),
    1: () => input.act('view-x'),
    2: () => input.act('view--x'),
    3: () => input.act('view-y'),
    4: () => input.act('view--y'),
    5: () => input.act('view-z'),
    6: () => input.act('view--z'),
    '+': () => input.act('closer'),
    '=': () => input.act('closer'),
    '-': () => input.act('farther'),
    o: () => input.act('perspective'),
    l: () => input.act('theme'),
    p: () => input.act('screenshot'),
    '?': () => input.act('help'),
    v: () => input.tool('look'),
    g: () => input.tool('face'),
    b: () => input.tool('brush'),
    x: () => input.tool('box'),
    m: () => input.next('mark', ['coping', 'wall']),
    t: () => input.next('mid', ['sheets', 'thickness']),
    h: () => input.next('part', ['solid', 'glass', 'hidden']),
    c: () => input.next('cut', ['off', 'x', 'y', 'z']),
    w: () => $('wire').click(),
    e: () => input.act('extract'),
    y: () => answerDoubt(true),
    n: () => answerDoubt(false),
    escape: () => input.escape(),
  },
  held: { z: 'undo', y: 'redo', s: 'save' },

  key(event) {
    if ($('help').open) return;
    const key = event.key.toLowerCase();
    if (event.ctrlKey || event.metaKey) {
      const name = key === 'z' && event.shiftKey ? 'redo' : input.held[key];
      if (!name) return;
      event.preventDefault();
      input.act(name);
      return;
    }
    const arrow = { arrowleft: [-1, 0], arrowright: [1, 0], arrowup: [0, 1], arrowdown: [0, -1] }[key];
    const onSlider = event.target.matches && event.target.matches('input[type="range"]');
    if (arrow && !onSlider) {
      event.preventDefault();
      if (event.shiftKey) page.camera.pan(-arrow[0] * 0.08, -arrow[1] * 0.08);
      else page.camera.turn(-arrow[0] * 0.12, arrow[1] * 0.12);
      page.render();
      return;
    }
    if (event.altKey || !Object.hasOwn(input.keys, key)) return;
    event.preventDefault();
    input.keys[key]();
  },

  listen() {
    const canvas = page.scene.canvas;
    canvas.addEventListener('pointerdown', input.down);
    canvas.addEventListener('pointermove', input.move);
    canvas.addEventListener('pointerup', input.up);
    canvas.addEventListener('pointercancel', input.up);
    canvas.addEventListener('pointerleave', (event) => {
      $('tip').hidden = true;
      $('ring').hidden = true;
      if (!input.drag) input.hover(event);
    });
    canvas.addEventListener('wheel', input.wheel, { passive: false });
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    document.addEventListener('keydown', input.key);
    document.addEventListener('click', (event) => {
      const link = event.target.closest('a[href="mid.html"]');
      if (link && page.tagging) {
        event.preventDefault();
        work.saveAs(link);
      }
      const button = event.target.closest('button');
      if (!button) return;
      const { tool, mark, part, mid, cut } = button.dataset;
      if (button.dataset.do) input.act(button.dataset.do);
      else if (tool) input.tool(tool);
      else {
        Object.assign(state, mark && { mark }, part && { part }, mid && { mid }, cut && { cut });
        page.update();
      }
    });
    for (const id of ['angle', 'brush', 'cut', 'wire', 'lines']) $(id).addEventListener('input', page.update);
    $('cell').addEventListener('input', work.estimate);
    new ResizeObserver(page.render).observe(canvas);
    window.addEventListener('beforeunload', (event) => {
      if (page.served && page.tagging && page.tagging.changed && page.tagging.done.length) event.preventDefault();
    });
  },
};
