'use strict';
// Takes the packs, from the server or from the page itself, and begins.

// A pack that the page carries, or null.
async function carried(id) {
  const element = document.getElementById(id);
  if (!element) return null;
  const bytes = Uint8Array.from(atob(element.textContent), (letter) => letter.charCodeAt(0));
  element.remove();
  const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return unpack(await new Response(plain).arrayBuffer());
}

async function fetched(name) {
  const answer = await fetch(name);
  if (answer.status === 204) return null;
  if (!answer.ok) throw new Error(await answer.text());
  return unpack(await answer.arrayBuffer());
}

function showFacts() {
  const { facts, triangles } = page.part;
  const size = facts.size.map((value) => figure(value)).join(' × ');
  $('facts').textContent = `${many(triangles.length / 3)} triangles · ${size}`
    + (facts.thickness ? ` · wall ${figure(facts.thickness, 3)}` : '');
}

// What takes the server a while to find out: wall thickness, or why the part cannot be extracted.
async function measure() {
  const { facts } = page.part;
  Object.assign(facts, await (await fetch('measure')).json());
  showFacts();
  work.estimate();
  document.querySelector('[data-do="extract"]').disabled = Boolean(facts.problem);
  if (!facts.problem) return;
  $('problem').hidden = false;
  $('problem').replaceChildren(make('b', '', [`Cannot be extracted: ${facts.problem.message}`]),
    make('p', '', [facts.problem.help || '']));
}

function showPart(pack) {
  const { facts } = pack;
  page.part = pack;
  page.camera.radius = facts.diagonal / 2 || 1;
  page.scene.setPart(pack);
  $('title').textContent = facts.title;
  showFacts();
  document.title = `${facts.title} – midsurf`;
  if (facts.verdict) page.say(facts.verdict, false, 12);
  page.doubts = facts.doubts || [];
  if (page.served) {
    page.tagging = new Tagging(pack);
    page.scene.mark(page.scene.part, page.tagging.marks);
  } else {
    const marks = new Uint8Array(padded(pack.coping.length));
    marks.set(pack.coping);
    page.scene.mark(page.scene.part, marks);
  }
}

async function start() {
  try {
    page.scene = new Scene($('canvas'));
    page.setTheme(matchMedia('(prefers-color-scheme: light)').matches ? 'light' : 'dark');
    let part = await carried('pack-part');
    page.served = !part;
    for (const id of ['tag-section', 'extract-section']) $(id).hidden = !page.served;
    if (page.served) part = await fetched('part');
    showPart(part);
    input.listen();
    work.estimate();
    page.fit();
    document.querySelector('[data-do="extract"]').disabled = page.served;
    const measured = page.served ? measure() : null;
    const mid = page.served ? await fetched('mid') : await carried('pack-mid');
    if (mid) takeMid(mid);
    else showLists();
    page.update();
    if (page.doubts.length) page.say(`${counted(page.doubts.length, 'question')} about coping faces: see Places`);
    document.documentElement.dataset.ready = 'yes';
    await measured;
  } catch (error) {
    page.say(error.message, true, 1e6);
    document.documentElement.dataset.ready = 'failed';
    throw error;
  }
}

start();
