'use strict';
// Colours that stay apart for every kind of colour vision: few hues, unlike in lightness, lines after
// Okabe and Ito's set; the ramp grows lighter all the way.

const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255);

const SHEETS = ['#7aaedc', '#eedd88', '#44b398', '#ee8f6a', '#c3a6e0', '#b8cc4a', '#ffb3c4', '#8fdcf0', '#c9c9c9'];
const RAMP = ['#1b2d72', '#226f9c', '#33a08d', '#a6c751', '#fbe34d'];
// Seam, coping border, fading border, crack.
const LINES = { dark: ['#f5713a', '#4ab4ff', '#2fd6a0', '#ff4fd8'], light: ['#c64a00', '#0062a8', '#008a60', '#c4009c'] };
const LINE_NAMES = ['Seams', 'Borders at coping', 'Borders that fade', 'Cracks'];
// Wall, coping, preview, cut.
const TINTS = { dark: ['#aab6c6', '#e69f00', '#ffe08a', '#5c6b80'], light: ['#b4c0ce', '#e69f00', '#fff0b8', '#8795a8'] };

function colorsOf(theme) {
  const ground = getComputedStyle(document.documentElement).getPropertyValue('--ground').trim();
  return {
    ground: rgb(ground),
    palette: SHEETS.map(rgb),
    ramp: RAMP.map(rgb),
    lines: LINES[theme].map(rgb),
    tints: TINTS[theme].map(rgb),
    overlay: [theme === 'dark' ? '#ffffff' : '#111111', '#56b4e9', '#56b4e9', '#56b4e9'].map(rgb),
  };
}

// A colour a sheet, so that no two that meet have the same where that can be: the largest sheets choose first.
function colorSheets(sheets) {
  const order = [...sheets.keys()].sort((a, b) => sheets[b].area - sheets[a].area || a - b);
  const color = new Uint8Array(sheets.length).fill(255);
  const used = new Array(SHEETS.length).fill(0);
  for (const sheet of order) {
    const taken = new Set(sheets[sheet].neighbours.map((other) => color[other]));
    let best = -1;
    for (let k = 0; k < SHEETS.length; k++) {
      if (!taken.has(k) && (best < 0 || used[k] < used[best])) best = k;
    }
    color[sheet] = best < 0 ? sheet % SHEETS.length : best;
    used[color[sheet]]++;
  }
  return color;
}
