'use strict';
// The mid-surface taken in, and lists of places to click through.

// Thickness at the ends of the ramp: all but the outermost hundredth, so that a few odd places do not
// flatten the rest.
function thicknessRange(mid) {
  const all = Float32Array.from(mid.thickness).sort();
  const at = (share) => all[Math.min(all.length - 1, Math.floor(share * all.length))];
  let [low, high] = [at(0.01), at(0.99)];
  page.thickness = [low, high];
  if (!(high - low > 1e-4 * high)) [low, high] = [low * 0.98, high * 1.02];
  return [low, high];
}

function takeMid(pack) {
  page.mid = pack;
  page.scene.setMid(pack);
  page.range = thicknessRange(pack);
  page.sheetColor = colorSheets(pack.facts.sheets);
  state.sheet = null;
  markSheets();
  if (state.part === 'solid') state.part = 'glass';
  if (state.mid === 'hidden') state.mid = 'sheets';
  clearPins();
  showResult();
  showLists();
  page.update();
}

// Marks of the mid-surface: colour of the sheet, and whether it stands out.
function markSheets() {
  const { sheets } = page.mid;
  const marks = new Uint8Array(padded(sheets.length));
  for (let n = 0; n < sheets.length; n++) {
    marks[n] = page.sheetColor[sheets[n]] | (sheets[n] === state.sheet ? 128 : 0);
  }
  page.scene.mark(page.scene.mid, marks);
  page.render();
}

function showResult() {
  const { facts } = page.mid;
  const counts = facts.counts;
  const rows = [
    ['Sheets', many(counts.sheets)],
    ['Thickness', [...new Set(page.thickness.map((value) => figure(value, 3)))].join(' to ')],
    ['Seams', many(counts.seams)],
    ['Junctions', many(counts.junctions)],
    ['Borders', `${many(counts.coping_borders)} coping, ${many(counts.fading_borders)} fading`],
    ['Pieces', many(counts.components)],
    ['Cracks', many(counts.cracks), counts.cracks ? 'bad' : 'good'],
    ['Area', figure(facts.area)],
    ['Triangles', many(counts.triangles)],
  ];
  if (facts.cell) rows.push(['Cell', figure(facts.cell)], ['Time', `${figure(facts.seconds, 2)} s`]);
  $('result').innerHTML = rows.map(([name, value, tone]) => `<dt>${name}</dt><dd class="${tone || ''}">${value}</dd>`).join('');
  $('result-section').hidden = false;
  $('downloads').hidden = !page.served;
}

const lists = { shown: null, all: [] };

// Lists that have anything in them, each with what a click on an entry does.
function showLists() {
  lists.all = [];
  const cracks = (page.mid && page.mid.facts.cracks) || [];
  if (cracks.length) {
    lists.all.push({
      name: 'Cracks',
      rows: cracks.map(({ at, length }) => ({
        text: page.inFile(at).map((value) => figure(value)).join(', '), note: figure(length), go: () => page.fly(at, length * 4),
      })),
    });
  }
  const closed = (page.mid && page.mid.facts.closed_over) || [];
  if (closed.length) {
    lists.all.push({
      name: 'Closed over',
      rows: closed.map(({ at, size, area }) => ({
        text: page.inFile(at).map((value) => figure(value)).join(', '), note: `area ${figure(area, 3)}`, go: () => page.fly(at, size),
      })),
    });
  }
  if (page.doubts && page.doubts.length) lists.all.push({ name: 'Doubts', rows: page.doubts.map(doubtRow) });
  if (page.mid) lists.all.push({ name: 'Sheets', rows: page.mid.facts.sheets.map(sheetRow) });
  $('list-section').hidden = !lists.all.length;
  if (!lists.all.some((list) => list.name === lists.shown)) lists.shown = lists.all.length ? lists.all[0].name : null;
  $('list-tabs').replaceChildren(...lists.all.map((list) => {
    const tab = make('button', '', [`${list.name} ${list.rows.length}`]);
    tab.setAttribute('role', 'tab');
    tab.setAttribute('aria-selected', String(list.name === lists.shown));
    tab.onclick = () => {
      lists.shown = list.name;
      showLists();
    };
    return tab;
  }));
  showRows();
}

function showRows() {
  const list = lists.all.find((each) => each.name === lists.shown);
  const rows = list ? list.rows : [];
  $('list').replaceChildren(...rows.map((row, n) => {
    const button = make('button');
    if (row.color) {
      const swatch = make('i', 'swatch');
      swatch.style.background = row.color;
      button.append(swatch);
    }
    button.append(make('span', '', [row.text]), make('span', row.answered ? 'figure answer' : 'figure', [row.note]));
    button.onclick = () => {
      for (const other of $('list').querySelectorAll('button')) other.removeAttribute('aria-current');
      button.setAttribute('aria-current', 'true');
      lists.at = n;
      row.go();
    };
    return make('li', '', [button]);
  }));
}

function thicknessOf({ thickness: { min, max } }) {
  const [low, high] = [figure(min, 3), figure(max, 3)];
  return low === high ? `t ${low}` : `t ${low}–${high}`;
}

function sheetRow(sheet, n) {
  return {
    text: `Sheet ${n}`,
    note: `${thicknessOf(sheet)}, area ${figure(sheet.area, 3)}`,
    color: SHEETS[page.sheetColor[n]],
    go() {
      const again = state.sheet === n;
      state.sheet = again ? null : n;
      markSheets();
      page.spot = null;
      $('marker').hidden = true;
      page.say(again ? 'All sheets' : `Sheet ${n} stands out; click it again for all`, false, 2);
    },
  };
}

// Faces that the detection is not sure of, as a question.
function doubtRow(doubt, n) {
  const now = doubt.coping ? 'coping' : 'wall';
  return {
    text: `${n + 1}. ${counted(doubt.faces, 'face')}`,
    note: doubt.answer || `${now}?`,
    answered: Boolean(doubt.answer),
    go() {
      page.doubt = doubt;
      page.sendMarks(page.tagging.preview(doubt.triangles));
      page.fly(doubt.at, doubt.size * 2);
      page.say(`${counted(doubt.faces, 'face')}, ${now} for now: ${doubt.reason}.\nIs it coping? Y yes, N no`, false, 60);
    },
  };
}

// Answers the doubt that is shown, and goes on to the next open one.
function answerDoubt(yes) {
  const doubt = page.doubt;
  if (!doubt) return;
  page.tagging.preview([]);
  page.tagging.set(doubt.triangles, yes);
  doubt.answer = yes ? 'coping' : 'wall';
  page.sendMarks();
  const next = page.doubts.find((other) => !other.answer);
  page.doubt = null;
  showLists();
  page.update();
  if (next) doubtRow(next, page.doubts.indexOf(next)).go();
  else page.say('No doubts left');
}

function clearPins() {
  for (const pin of page.pins) pin.element.remove();
  page.pins = [];
}

// A measure that stays where it was taken.
function pin(at, text) {
  const element = make('div', 'pin', [text]);
  $('pins').append(element);
  page.pins.push({ element, at });
  page.render();
}
