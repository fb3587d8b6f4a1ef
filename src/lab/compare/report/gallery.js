// The gallery: verdicts on each method and scene, what they rest on, and why the red ones are red.

const VERDICTS = { green: ['✓', 'passed'], amber: ['~', 'not known, or worse within its bound'], red: ['✗', 'failed'] };

const CHECKS = { unbiased: 'Unbiased', finite: 'Finite', efficiency: 'Efficiency', fireflies: 'Fireflies',
  explosion: 'Explosion', memory: 'Memory', repeatable: 'Repeatable' };

const spread = cell => cell.relmse_median > 0 ? cell.relmse_worst / cell.relmse_median : null;

function galleryCell(cell) {
  if (!cell) return el('td', null, 'not run');
  const [mark, words] = VERDICTS[cell.colour];
  const button = el('button', { type: 'button', class: `verdict ${cell.colour}`, 'aria-expanded': false,
    'aria-controls': 'gallery-detail', onclick: () => showVerdict(cell, button) },
    el('span', { class: 'mark', 'aria-label': words, role: 'img' }, mark),
    el('span', { class: 'figure' }, times(cell.ratio.value)),
    el('span', { class: 'figure small' }, `worst ${times(spread(cell))}`));
  return el('td', null, button);
}

function finding(found) {
  const [mark, words] = VERDICTS[found.colour];
  const why = found.colour === 'red'
    ? el('strong', { class: found.why ? null : 'flag' }, found.why ?? 'Unexplained: no sentence tells why.') : null;
  return el('li', { class: `finding ${found.colour}` },
    el('span', { class: 'mark', 'aria-label': words, role: 'img' }, mark),
    el('span', null, `${CHECKS[found.check]}: ${found.says}`), why);
}

/** What a cell's verdict rests on, below the matrix. */
function showVerdict(cell, button) {
  document.querySelectorAll('.verdict').forEach(other => { other.ariaExpanded = other === button; });
  const seen = results.images.some(image => image.scene === cell.scene && image.method === cell.method);
  const pictures = el('button', { type: 'button', onclick: () => showPictureOf(cell) }, 'Show the pictures');
  const bytes = `Guide of ${count(cell.guide_bytes)} bytes at most; relMSE of the median run`
    + ` ${figure(cell.relmse_median)}, of the worst ${figure(cell.relmse_worst)}.`;
  byId('gallery-detail').replaceChildren(
    el('h3', { tabindex: -1 }, `${cell.scene}, ${cell.method}: ${VERDICTS[cell.colour][1]}`),
    el('ul', { class: 'findings' }, cell.findings.map(finding)), el('p', { class: 'soft' }, bytes),
    ...(seen ? [pictures] : []));
  byId('gallery-detail').querySelector('h3').focus({ preventScroll: false });
}

/** Opens the viewer with a cell's picture beside the reference. */
function showPictureOf(cell) {
  const tab = [...document.querySelectorAll('#pictures [role=tab]')].find(tab => tab.textContent === cell.scene);
  viewer.wanted = cell.method;
  tab?.click();
  byId('pictures').scrollIntoView();
  byId('stage').focus({ preventScroll: true });
}

/** What the marks mean, and where their bounds are. */
function galleryTerms({ bounds, tested, level, budget }) {
  return `Budget ${budget}. In each cell the verdict, the efficiency over that of ${results.baseline}, and how many times`
    + ` the median run’s error the worst has. ✓ all checks are passed; ~ something is not known, or worse than without a`
    + ` guide within its bound; ✗ a check failed. The bounds: a bias whose p is below ${figure(level)} (all ${count(tested)}`
    + ` tests together are wrong with probability ${bounds.alarm}); efficiency below 1/${bounds.slower} of the baseline's;`
    + ` ${100 * bounds.fireflies} % of the error in the worst 0.1 % of the pixels; a run ${bounds.explosion} times as bad`
    + ' as the median one. The last two are red only where the baseline does not do the same.';
}

function showGallery() {
  const { gallery } = results;
  if (!gallery) return;
  const found = new Map(gallery.cells.map(cell => [keyOf(cell.scene, cell.method, ''), cell]));
  const row = scene => el('tr', null, el('th', { scope: 'row' }, scene),
    methodNames.map(method => galleryCell(found.get(keyOf(scene, method, '')))));
  const table = el('table', { class: 'gallery' },
    el('thead', null, el('tr', null, el('td'), methodNames.map(name => el('th', { scope: 'col' }, name)))),
    el('tbody', null, sceneNames.map(row)));
  const reds = gallery.cells.filter(cell => cell.colour === 'red').length;
  const unexplained = gallery.cells.flatMap(cell => cell.findings)
    .filter(({ colour, why }) => colour === 'red' && !why).length;
  const says = [`${plural(reds, 'cell')} of ${count(gallery.cells.length)} failed.`,
    unexplained > 0 ? el('strong', { class: 'flag' }, ` ${plural(unexplained, 'failure')} unexplained.`) : null];
  byId('gallery').append(el('p', null, says.filter(part => part != null)),
    el('p', { class: 'soft' }, galleryTerms(gallery)),
    el('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Verdicts' }, table),
    el('div', { id: 'gallery-detail' }, el('p', { class: 'soft' }, 'Choose a cell to see what its verdict rests on.')));
  byId('gallery').hidden = false;
  byId('gallery-link').hidden = false;
}
