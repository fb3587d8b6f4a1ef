// What the viewer's pictures are chosen and changed with.

function drawPickers() {
  const { mode, shown, current, pictures } = viewer;
  const names = pictures.map((picture, i) => [String(i), `${i + 1} ${picture.label}`]);
  if (mode === 'slider') {
    const side = (label, key) => select(label, names, String(viewer[key]), value => {
      viewer[key] = Number(value);
      requestDraw();
    });
    byId('pickers').replaceChildren(side('Left', 'left'), side('Right', 'right'));
    return;
  }
  const buttons = [...byId('pickers').querySelectorAll('button')];
  const label = el('span', { class: 'soft' }, mode === 'grid' ? 'Shown' : 'Showing');
  // The buttons are kept: a new one would not have the focus.
  const kept = names.map(([, name], i) => buttons[i]?.textContent === name ? buttons[i] : pickButton(name, i));
  kept.forEach((button, i) => { button.ariaPressed = mode === 'grid' ? shown.has(i) : i === current; });
  byId('pickers').replaceChildren(label, ...kept);
}

/** After a click the keys are the stage's, so that the space bar flips; after a key the focus stays. */
function pickButton(name, index) {
  const onclick = event => {
    pick(index);
    if (event.detail > 0) byId('stage').focus({ preventScroll: true });
  };
  return el('button', { type: 'button', onclick }, name);
}

function exposure() {
  const shown = el('output', { for: 'exposure' });
  const range = el('input', { type: 'range', id: 'exposure', min: -12, max: 12, step: 0.25 });
  const set = stops => {
    viewer.stops = stops;
    range.value = stops;
    shown.textContent = `${stops < 0 ? '−' : '+'}${Math.abs(stops).toFixed(2)} stops`;
    range.setAttribute('aria-valuetext', shown.textContent);
    requestDraw();
  };
  range.addEventListener('input', () => set(Number(range.value)));
  const auto = () => set(viewer.pictures[0]?.middleGrey() ?? 0);
  const title = 'Brings the geometric mean of the first picture to middle grey';
  const reset = el('button', { type: 'button', onclick: auto, title }, 'Auto');
  const label = el('label', { for: 'exposure' }, 'Exposure');
  return { auto, box: el('div', { class: 'exposure' }, label, range, shown, reset),
    enable: on => { range.disabled = reset.disabled = !on; } };
}

function zoomButtons() {
  const button = (label, name, act) => el('button', { type: 'button', 'aria-label': name, title: name,
    onclick: () => viewer.panels.length > 0 && act(viewer.panels[0].canvas) }, label);
  return el('div', { class: 'zoom', role: 'group', 'aria-label': 'Zoom' },
    button('−', 'Smaller', canvas => view.zoomBy(canvas, 1 / 1.5)),
    button('+', 'Larger', canvas => view.zoomBy(canvas, 1.5)),
    button('Fit', 'The whole picture', () => view.fit()),
    button('1:1', 'One pixel on one of the screen', canvas => view.zoomBy(canvas, view.actual(canvas) / view.zoom)));
}

function errorLegend() {
  const [low, high] = ERROR_DECADES;
  const ticks = Array.from({ length: high - low + 1 }, (_, i) => low + i);
  const mark = power => el('span', null, '10', el('sup', null, power < 0 ? `−${-power}` : `${power}`));
  const bar = el('div', { class: 'bar' });
  bar.style.background = `linear-gradient(to right, ${FALSE_COLOURS.join(', ')})`;
  return el('div', { id: 'error-legend', class: 'error-legend', hidden: true },
    el('p', null, 'Relative square error (x − r)² / (r² + 0.01), mean over channels; darker and lighter than the ends'
      + ' are drawn as the ends.'),
    bar, el('div', { class: 'ticks' }, ticks.map(mark)));
}

function readout() {
  const heads = ['R', 'G', 'B', 'Rel. square error'].map(head => el('th', { scope: 'col' }, head));
  return el('div', { class: 'scroll' }, el('table', { class: 'plain', id: 'readout' },
    el('thead', null, el('tr', null, el('th', { scope: 'col', id: 'readout-place' }), heads)), el('tbody')));
}

function listenToStage(stage) {
  listenToWheel(stage, view);
  listenToPointers(stage, view);
  stage.addEventListener('pointermove', event => {
    if (event.target.localName !== 'canvas') return;
    viewer.over = event.target;
    probeAt(view.place(event.target, event.clientX, event.clientY));
  });
  stage.addEventListener('pointerleave', () => { viewer.over = null; requestDraw(); });
  new ResizeObserver(requestDraw).observe(stage);
}

/** Digits choose from anywhere in the viewer; the other keys are the stage's. */
function viewerKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || viewer.panels.length === 0) return;
  if (/^[1-9]$/.test(event.key) && event.target.localName !== 'select') pick(Number(event.key) - 1);
  else if (event.target.id !== 'stage') return;
  else if (event.key === ' ' && viewer.mode !== 'grid') flip();
  else if (viewKey(event.key, viewer.panels[0].canvas, view)) probeAt(view.centre);
  else return;
  event.preventDefault();
}

/** Loads a scene's pictures; of two loads at once the later one counts. */
async function openPictures(scene, budget, light) {
  Object.assign(viewer, { scene, budget, pictures: [], panels: [], probe: null });
  byId('pickers').replaceChildren();
  byId('stage').replaceChildren(el('p', { role: 'status' }, 'Unpacking the pictures …'));
  let pictures;
  try {
    pictures = await loadPictures(scene, budget);
  } catch (error) {
    byId('stage').replaceChildren(el('p', { role: 'alert' }, `The pictures cannot be unpacked: ${error.message}.`));
    return;
  }
  if (viewer.scene !== scene || viewer.budget !== budget) return;
  const last = pictures.length - 1;
  Object.assign(viewer, { pictures, shown: wantedPictures(pictures), current: 0, previous: last, left: 0, right: last });
  view.show(pictures[0].width, pictures[0].height);
  const row = picture => el('tr', null, el('th', { scope: 'row' }, picture.label),
    Array.from({ length: 4 }, () => el('td')));
  byId('readout').querySelector('tbody').replaceChildren(...pictures.map(row));
  light.auto();
  drawPickers();
  buildStage();
}

/** All of them, or the reference and the one method that was asked for. */
function wantedPictures(pictures) {
  const { wanted } = viewer;
  viewer.wanted = null;
  const indices = [...pictures.keys()];
  return new Set(wanted ? indices.filter(i => !pictures[i].reference || pictures[i].method === wanted) : indices);
}

function viewerControls(light) {
  const modes = [['grid', 'side by side'], ['slider', 'slider'], ['flip', 'flip']];
  const setMode = mode => {
    viewer.mode = mode;
    if (viewer.pictures.length === 0) return;
    drawPickers();
    buildStage();
  };
  const setError = error => {
    viewer.error = error;
    byId('error-legend').hidden = !error;
    light.enable(!error);
    requestDraw();
  };
  return el('div', { class: 'controls' }, el('span', { id: 'picture-budget' }),
    choice('viewer-mode', 'Pictures', modes, viewer.mode, setMode),
    choice('viewer-what', 'Show', [['picture', 'picture'], ['error', 'error']], 'picture',
      what => setError(what === 'error')),
    light.box, zoomButtons());
}

/** Budgets that a scene has pictures of; the reference belongs to all. */
function pictureBudgets(scene) {
  const has = budget => results.images.some(image => image.scene === scene && image.budget === budget);
  return budgetNames.filter(has);
}

function viewerBody(light) {
  const stage = el('div', { id: 'stage', class: 'stage', tabindex: 0, role: 'group', 'aria-label': 'Pictures',
    'aria-describedby': 'viewer-keys' });
  const keys = 'With the pictures in focus: wheel, + and − zoom, drag and arrow keys move, 0 shows the whole; 1 to 9'
    + ' choose a picture, the space bar flips between the last two chosen, or swaps the slider’s sides. Exposure is in'
    + ' stops, before the sRGB curve.';
  listenToStage(stage);
  return el('div', { id: 'viewer', role: 'tabpanel', onkeydown: viewerKey },
    el('h3', { class: 'print-only', id: 'viewer-scene' }), viewerControls(light),
    el('div', { class: 'controls', id: 'pickers' }), stage, errorLegend(), readout(),
    el('p', { id: 'viewer-keys', class: 'soft' }, keys));
}

/** A scene's pictures under the last of the budgets that it has any of. */
function openScene(scene, light) {
  byId('viewer').setAttribute('aria-label', scene);
  byId('viewer-scene').textContent = scene;
  const budgets = pictureBudgets(scene);
  const last = budgets.at(-1) ?? null;
  const chosen = budget => openPictures(scene, budget, light);
  byId('picture-budget').replaceChildren(budgets.length > 1
    ? select('Budget', budgets.map(name => [name, name]), last, chosen) : el('span', { class: 'soft' }, last ?? ''));
  chosen(last);
}

function showPictures() {
  const scenes = sceneNames.filter(name => results.images.some(image => image.scene === name));
  if (scenes.length === 0) {
    byId('pictures').append(el('p', null, 'These results hold no pictures.'));
    return;
  }
  const light = exposure();
  const body = viewerBody(light);
  byId('pictures').append(body);
  body.before(tabs('Pictures of', scenes, () => 'viewer', index => openScene(scenes[index], light)));
}
