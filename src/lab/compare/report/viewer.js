// Pictures beside each other, under a slider, or flipped: what is chosen, and how it is drawn.

const viewer = {
  pictures: [], scene: null, budget: null, mode: 'grid', error: false, stops: 0,
  shown: new Set(), wanted: null, current: 0, previous: 0, left: 0, right: 0, split: 0.5,
  /** The pixel that is read out, and the canvas that the pointer is over. */
  probe: null, over: null, panels: [], table: null, colours: null,
};

const view = new View(() => requestDraw());

let drawAsked = false;

function requestDraw() {
  if (drawAsked) return;
  drawAsked = true;
  requestAnimationFrame(() => {
    drawAsked = false;
    drawPanels();
    drawReadout();
  });
}

/** What a picture looks like now; the reference, having no error, is shown as it is. */
function looks(picture) {
  if (viewer.error && picture.reference) return picture.falseColour(viewer.colours ??= falseColours());
  if (viewer.table?.stops !== viewer.stops) {
    viewer.table = { stops: viewer.stops, bytes: toneTable(viewer.stops) };
  }
  return picture.tone(viewer.stops, viewer.table.bytes);
}

/** relMSE of the run that a picture is of. */
function errorOf({ method, seed }) {
  const run = results.runs.find(run => run.scene === viewer.scene && run.budget === viewer.budget
    && run.method === method && run.seed === seed);
  return run?.relmse ?? null;
}

function caption(index) {
  const picture = viewer.pictures[index];
  const error = errorOf(picture);
  const note = viewer.error && !picture.reference ? ', as a picture' : error == null ? '' : `, relMSE ${figure(error)}`;
  return `${index + 1}  ${picture.label}${note}`;
}

/** A panel: a canvas whose `layers` are [picture, from, to], the last two being shares of its width. */
function panel(says, layers, ...extra) {
  const canvas = el('canvas', { class: 'panel' });
  canvas.style.aspectRatio = view.size.join(' / ');
  const title = el('figcaption', { 'aria-live': viewer.mode === 'flip' ? 'polite' : null });
  viewer.panels.push({ canvas, title, says, layers });
  return el('figure', null, el('div', { class: 'frame' }, canvas, extra), title);
}

function buildStage() {
  viewer.panels = [];
  viewer.over = null;
  const stage = byId('stage');
  stage.className = `stage ${viewer.mode}`;
  stage.style.setProperty('--aspect', view.size[0] / view.size[1]);
  const whole = index => [[index(), 0, 1]];
  if (viewer.mode === 'grid') {
    const shown = [...viewer.shown].sort((a, b) => a - b);
    stage.replaceChildren(...shown.map(i => panel(() => caption(i), () => whole(() => i))));
  } else if (viewer.mode === 'flip') {
    stage.replaceChildren(panel(() => caption(viewer.current), () => whole(() => viewer.current)));
  } else {
    stage.replaceChildren(panel(() => `${caption(viewer.left)}  |  ${caption(viewer.right)}`,
      () => [[viewer.left, 0, viewer.split], [viewer.right, viewer.split, 1]], splitter()));
  }
  requestDraw();
}

/** The bar between the two pictures of a slider. */
function splitter() {
  const bar = el('div', { role: 'slider', tabindex: 0, 'aria-label': 'Border between the pictures', class: 'splitter',
    'aria-valuemin': 0, 'aria-valuemax': 100 });
  const move = split => {
    viewer.split = clamp(split, 0, 1);
    bar.style.left = `${100 * viewer.split}%`;
    bar.ariaValueNow = Math.round(100 * viewer.split);
    requestDraw();
  };
  const follow = event => {
    const box = bar.parentElement.getBoundingClientRect();
    move((event.clientX - box.left) / box.width);
  };
  bar.addEventListener('pointerdown', () => {
    window.addEventListener('pointermove', follow);
    for (const end of ['pointerup', 'pointercancel']) {
      window.addEventListener(end, () => window.removeEventListener('pointermove', follow), { once: true });
    }
  });
  bar.addEventListener('keydown', event => {
    const to = { ArrowLeft: viewer.split - 0.02, ArrowRight: viewer.split + 0.02, Home: 0, End: 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    move(to);
  });
  move(viewer.split);
  return bar;
}

function drawPanels() {
  byId('stage').style.touchAction = view.zoom > 1 ? 'none' : 'pan-y';
  for (const { canvas, title, says, layers } of viewer.panels) {
    const words = says();
    if (title.textContent !== words) title.textContent = words;
    drawLayers(canvas, layers());
    if (viewer.mode === 'grid' && viewer.probe && canvas !== viewer.over) drawMark(canvas);
  }
}

/** Enlarged pixels keep hard edges: nothing is shown that was not rendered. */
function drawLayers(canvas, layers) {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map(side => Math.round(side * devicePixelRatio));
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const context = canvas.getContext('2d');
  const scale = view.scale(canvas) * devicePixelRatio;
  context.clearRect(0, 0, width, height);
  context.imageSmoothingEnabled = scale < 1;
  for (const [index, from, to] of layers) {
    context.save();
    context.beginPath();
    context.rect(Math.round(from * width), 0, Math.round(to * width) - Math.round(from * width), height);
    context.clip();
    context.setTransform(scale, 0, 0, scale, width / 2 - view.centre[0] * scale, height / 2 - view.centre[1] * scale);
    context.drawImage(looks(viewer.pictures[index]), 0, 0);
    context.restore();
  }
}

/** A frame about the pixel that is read out, in the panels that the pointer is not over. */
function drawMark(canvas) {
  const context = canvas.getContext('2d');
  const scale = view.scale(canvas) * devicePixelRatio;
  const side = Math.max(scale, 9);
  const half = [canvas.width / 2, canvas.height / 2];
  const [x, y] = viewer.probe.map((p, i) => half[i] + (p + 0.5 - view.centre[i]) * scale - side / 2);
  for (const [colour, width] of [['#000', 3], ['#fff', 1]]) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.strokeRect(x, y, side, side);
  }
}

/** Reads out the pixel at a place of the picture, if there is one. */
function probeAt([x, y]) {
  const pixel = [Math.floor(x), Math.floor(y)];
  viewer.probe = pixel.every((p, i) => p >= 0 && p < view.size[i]) ? pixel : null;
  requestDraw();
}

function drawReadout() {
  const { probe, pictures } = viewer;
  byId('readout-place').textContent = probe ? `Pixel ${probe[0]}, ${probe[1]}` : 'Point at a picture';
  byId('readout').querySelectorAll('tbody tr').forEach((row, i) => {
    const values = probe ? [...pictures[i].at(...probe), pictures[i].errorAt(...probe)] : [null, null, null, null];
    [...row.cells].slice(1).forEach((cell, k) => { cell.textContent = figure(values[k]); });
  });
}

/** What a digit or a button of the list of pictures does. */
function pick(index) {
  if (index >= viewer.pictures.length) return;
  if (viewer.mode === 'grid') {
    const { shown } = viewer;
    if (!shown.delete(index)) shown.add(index);
    if (shown.size === 0) shown.add(index);
    buildStage();
  } else if (viewer.mode === 'slider') {
    viewer.right = index;
  } else if (index !== viewer.current) {
    [viewer.previous, viewer.current] = [viewer.current, index];
  }
  drawPickers();
  requestDraw();
}

function flip() {
  if (viewer.mode === 'flip') [viewer.previous, viewer.current] = [viewer.current, viewer.previous];
  else [viewer.left, viewer.right] = [viewer.right, viewer.left];
  drawPickers();
  requestDraw();
}
