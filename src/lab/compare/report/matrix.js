// Scenes × methods: efficiency over the baseline's.

const matrix = { budget: budgetNames.at(-1), trimmed: false };

/** Ratios at which the colour is at its strongest are this many doublings away from 1. */
const DOUBLINGS = 3;

/** From 0.2, so that no colour is not taken for a weak one, to 1. */
const strength = ratio => (0.2 + 0.8 * Math.min(1, Math.abs(Math.log2(ratio)) / DOUBLINGS)).toFixed(3);

const verdictWords = { better: null, worse: null, undecided: 'not told from 1', unknown: 'no interval' };

function matrixCell(scene, method) {
  const cell = cells.get(keyOf(scene, method, matrix.budget));
  if (!cell) return el('td', { class: 'undecided' }, 'not run');
  const ratio = matrix.trimmed ? cell.ratio_trimmed : cell.ratio;
  const base = method === results.baseline;
  const sure = base ? 'undecided' : verdict(ratio);
  const coloured = ['better', 'worse'].includes(sure) && !cell.bias.biased;
  const words = base ? 'the baseline' : verdictWords[sure];
  const look = coloured ? { class: sure, style: `--strength: ${strength(ratio.value)}` } : { class: 'undecided' };
  return el('td', look,
    el('span', { class: 'ratio' }, times(ratio.value)),
    !base && hasInterval(ratio) ? el('span', null, interval(ratio)) : null,
    words ? el('span', null, words) : null,
    el('span', { class: 'errors' }, `median ${figure(cell.relmse_median)}`),
    el('span', { class: 'errors' }, `worst ${figure(cell.relmse_worst)}`),
    flags(cell).map(flag => el('strong', { class: 'flag' }, flag)));
}

/** The geometric means, below the scenes. */
function meanRow() {
  const cell = method => {
    const mean = overallOf(method, matrix.budget)?.[matrix.trimmed ? 'ratio_trimmed' : 'ratio'];
    if (!mean || mean.scenes < 2) return el('td', { class: 'undecided' }, method === results.baseline ? '1' : UNDEFINED);
    const sure = verdict(mean);
    const coloured = ['better', 'worse'].includes(sure);
    return el('td', coloured ? { class: sure, style: `--strength: ${strength(mean.value)}` } : { class: 'undecided' },
      el('span', { class: 'ratio' }, times(mean.value)), hasInterval(mean) ? el('span', null, interval(mean)) : null,
      el('span', { class: 'errors' }, `scenes differ by ${times(mean.spread)}`));
  };
  return el('tr', null, el('th', { scope: 'row' }, 'geometric mean'), methodNames.map(cell));
}

function drawMatrix() {
  const head = method => el('th', { scope: 'col' }, method);
  const row = scene => el('tr', null, el('th', { scope: 'row' }, scene), methodNames.map(m => matrixCell(scene, m)));
  const error = matrix.trimmed ? 'trimmed relMSE' : 'relMSE';
  byId('matrix-says').textContent = `Efficiency by ${error} over that of ${results.baseline}, budget ${matrix.budget},`
    + ` with ${confidence} intervals; below it the median and the worst relMSE of the runs.`;
  byId('matrix-box').replaceChildren(el('table', { class: 'matrix', 'aria-describedby': 'matrix-says' },
    el('thead', null, el('tr', null, el('td'), methodNames.map(head))),
    el('tbody', null, sceneNames.map(row)),
    ...(results.overall ? [el('tfoot', null, meanRow())] : [])));
}

function swatch(log) {
  const label = log < 0 ? `1/${2 ** -log}` : `${2 ** log}`;
  const side = log === 0 ? 'undecided' : log > 0 ? 'better' : 'worse';
  return el('span', { class: `swatch ${side}`, style: `--strength: ${strength(2 ** log)}` }, label);
}

function showMatrix() {
  const pairs = budgetNames.map(name => [name, name]);
  const redraw = change => { Object.assign(matrix, change); drawMatrix(); };
  byId('matrix-controls').append(
    choice('matrix-budget', 'Budget', pairs, matrix.budget, budget => redraw({ budget })),
    choice('matrix-error', 'Error', [['all', 'relMSE'], ['trimmed', 'trimmed relMSE']], 'all',
      value => redraw({ trimmed: value === 'trimmed' })));
  byId('matrix-legend').append(
    el('span', null, 'less efficient'),
    el('span', { class: 'swatches' }, [-3, -2, -1, 0, 1, 2, 3].map(swatch)),
    el('span', null, 'more efficient'),
    el('span', { class: 'soft' }, 'No colour: the interval holds 1, there is none, or the method is biased.'));
  drawMatrix();
}
