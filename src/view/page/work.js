'use strict';
// What the server is asked to do.

const work = {
  running: null,
  // Seconds an active cell took last time; until then a guess for a usual machine.
  perCell: 2.5e-4,

  cell() {
    const thickness = page.part.facts.thickness;
    return thickness ? thickness * 2 ** Number($('cell').value) : null;
  },

  estimate() {
    const { thickness, cells_at_thickness: cells } = page.part.facts;
    const times = 2 ** Number($('cell').value);
    if (!thickness) {
      $('cell-out').value = '–';
      $('estimate').textContent = '';
      return;
    }
    const count = cells / times ** 2;
    const seconds = count * work.perCell;
    $('cell-out').value = `${figure(thickness * times, 3)} = ${figure(times, 2)} wall thicknesses`;
    const time = seconds < 1 ? 'under a second' : seconds < 90 ? `some ${figure(seconds, 1)} s` : `some ${figure(seconds / 60, 1)} min`;
    $('estimate').textContent = `About ${many(Number(count.toPrecision(2)))} cells, ${time}.`;
  },

  busy(on) {
    document.querySelector('[data-do="extract"]').hidden = on;
    document.querySelector('[data-do="cancel"]').hidden = !on;
    $('progress').hidden = !on;
    $('progress').removeAttribute('value');
    $('stage').textContent = '';
    $('cell').disabled = on;
  },

  async extract() {
    if (document.querySelector('[data-do="extract"]').disabled || !page.served || work.running) return;
    work.running = new AbortController();
    work.busy(true);
    try {
      const address = `extract?cell=${work.cell() || 'auto'}`;
      const answer = await fetch(address, { method: 'POST', body: page.tagging.flags(), signal: work.running.signal });
      if (!answer.ok) throw new Error(await answer.text());
      const last = await work.follow(answer.body.getReader());
      if (last.error) throw new Error(last.help ? `${last.error}. ${last.help}` : last.error);
      work.learn(last.result);
      takeMid(unpack(await (await fetch('mid')).arrayBuffer()));
      const cracks = page.mid.facts.counts.cracks;
      page.say(cracks ? `Done, with ${many(cracks)} cracks: see the list` : 'Done, without cracks', cracks > 0);
    } catch (error) {
      if (error.name === 'AbortError') page.say('Stopped');
      else page.say(error.message, true);
    }
    work.running = null;
    work.busy(false);
    work.estimate();
  },

  // What was counted and timed is better than what was estimated.
  learn({ cells, seconds, cell }) {
    const { facts } = page.part;
    if (!cells) return;
    work.perCell = seconds / cells;
    if (facts.thickness && cell) facts.cells_at_thickness = cells * (cell / facts.thickness) ** 2;
  },

  // Reads lines until the last, showing how far the work is.
  async follow(reader) {
    const decoder = new TextDecoder();
    let rest = '';
    let last = { error: 'the server went away' };
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return last;
      rest += decoder.decode(value, { stream: true });
      const lines = rest.split('\n');
      rest = lines.pop();
      for (const line of lines) {
        last = JSON.parse(line);
        if (!last.stage) continue;
        $('stage').textContent = last.of ? `${last.stage} ${many(last.done)}` : last.stage;
        if (last.of) $('progress').value = last.done / last.of;
        else $('progress').removeAttribute('value');
      }
    }
  },

  // Breaking the connection is what stops the work.
  cancel() {
    if (work.running) work.running.abort();
  },

  async save(replace = false) {
    if (!page.served || !page.tagging.changed) return;
    const flags = page.tagging.flags();
    try {
      const answer = await fetch(replace ? 'save?replace' : 'save', { method: 'POST', body: flags });
      if (answer.status === 409) {
        const file = page.part.facts.tag_file;
        if (window.confirm(`${file} is there already and was not read here. Replace it?`)) await work.save(true);
        return;
      }
      if (!answer.ok) throw new Error(await answer.text());
      page.tagging.markSaved();
      page.update();
      page.say(`Saved ${page.part.facts.tag_file}`);
    } catch (error) {
      page.say(error.message, true);
    }
  },

  // The page as a file shows the tags as they are now, saved or not.
  async saveAs(link) {
    try {
      const answer = await fetch('tags', { method: 'POST', body: page.tagging.flags() });
      if (!answer.ok) throw new Error(await answer.text());
      const file = document.createElement('a');
      file.href = link.href;
      file.download = '';
      file.click();
    } catch (error) {
      page.say(error.message, true);
    }
  },

  // The picture as it is, as a file.
  screenshot() {
    page.draw();
    page.scene.canvas.toBlob((blob) => {
      const link = document.createElement('a');
      link.href = URL.createObjectURL(blob);
      link.download = `${page.part.facts.title.replace(/\.[^.]*$/, '')}.png`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
      page.say(`Picture saved as ${link.download}`, false, 2);
    });
  },
};
