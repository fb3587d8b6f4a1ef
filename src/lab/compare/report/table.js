// All cells, sorted and filtered.

const text = key => ({ label: key[0].toUpperCase() + key.slice(1), main: true, head: true,
  value: cell => cell[key], show: cell => cell[key], fields: [[key, cell => cell[key]]] });

const plain = (name, label, value, main = false) => ({ label, main, value,
  show: cell => Number.isInteger(value(cell)) ? count(value(cell)) : figure(value(cell)), fields: [[name, value]] });

/** A mean (or a ratio) with its interval; `unit` is what the shown figure is divided by. */
function measured(key, label, main = false, unit = 1) {
  const part = name => cell => cell[key]?.[name] ?? null;
  const middle = cell => part('mean')(cell) ?? part('value')(cell);
  const scaled = value => value == null ? null : value / unit;
  // The baseline's ratio to itself is exact.
  const spread = cell => hasInterval(cell[key]) && cell[key].low < cell[key].high;
  const range = cell => interval({ low: scaled(cell[key].low), high: scaled(cell[key].high) });
  return { label, main, value: middle,
    show: cell => [figure(scaled(middle(cell))),
      spread(cell) ? el('span', { class: 'interval' }, range(cell)) : null],
    fields: [[key, middle], [`${key}_low`, part('low')], [`${key}_high`, part('high')]] };
}

const said = value => value == null ? 'not tested' : value ? 'biased' : 'no';

const columns = [
  text('scene'), text('method'), text('budget'),
  plain('runs', 'Runs', cell => cell.runs, true),
  measured('ratio', 'Efficiency ratio', true), measured('ratio_trimmed', 'Ratio, trimmed', true),
  measured('relmse', 'relMSE', true), measured('relmse_trimmed', 'relMSE, trimmed', true),
  plain('relmse_median', 'relMSE, median', cell => cell.relmse_median),
  plain('relmse_worst', 'relMSE, worst', cell => cell.relmse_worst),
  measured('mse', 'MSE'), measured('mape', 'MAPE'), measured('smape', 'SMAPE'), measured('flip', 'FLIP', true),
  measured('efficiency', 'Efficiency / s⁻¹'), measured('efficiency_trimmed', 'Efficiency, trimmed / s⁻¹'),
  measured('wall_seconds', 'Wall time [s]', true), measured('samples', 'Samples per pixel', true),
  measured('msamples_per_second', '10⁶ samples / s'), measured('mrays_per_second', '10⁶ rays / s'),
  measured('mean_path_length', 'Path length', true), measured('zero_share', 'Share of zeros'),
  measured('guide_bytes', 'Guide / MiB', true, 2 ** 20), measured('guide_states', 'Guide’s states'),
  measured('peak_bytes', 'Peak memory / MiB', false, 2 ** 20),
  { label: 'Biased', main: true, value: cell => cell.bias.biased == null ? null : Number(cell.bias.biased),
    show: cell => said(cell.bias.biased), fields: [['biased', cell => cell.bias.biased]] },
  plain('bias_z', 'Bias, z', cell => cell.bias.z), plain('bias_p', 'Bias, p', cell => cell.bias.p),
  plain('non_finite', 'Not finite', cell => cell.non_finite, true),
];

const table = { column: null, descending: false, scene: '', budget: '', all: false };

/** Numbers by size, words as a person would; what is undefined comes last both ways. */
function compare(a, b) {
  if (a == null || b == null) return null;
  return typeof a === 'string' ? a.localeCompare(b, 'en', { numeric: true }) : a - b;
}

/** The cells that pass the filters, in order; equal ones stay as they were written. */
function chosenCells() {
  const found = results.cells.filter(cell => (!table.scene || cell.scene === table.scene)
    && (!table.budget || cell.budget === table.budget));
  if (!table.column) return found;
  const { value } = table.column;
  return found.sort((a, b) => {
    const [x, y] = [value(a), value(b)];
    const order = compare(x, y);
    if (order === null) return (x == null) - (y == null);
    return table.descending ? -order : order;
  });
}

function sortBy(column) {
  table.descending = table.column === column && !table.descending;
  table.column = column;
  drawRows();
}

function drawRows() {
  const shown = columns.filter(column => table.all || column.main);
  const box = byId('table-box');
  const cell = (column, row) => column.head
    ? el('th', { scope: 'row' }, column.show(row)) : el('td', null, column.show(row));
  const rows = chosenCells().map(row => el('tr', { class: flags(row).length > 0 ? 'flagged' : null },
    shown.map(column => cell(column, row))));
  box.querySelector('tbody').replaceChildren(...rows);
  for (const head of box.querySelectorAll('thead th')) {
    const sorted = table.column?.label === head.textContent;
    head.ariaSort = !sorted ? 'none' : table.descending ? 'descending' : 'ascending';
  }
  byId('table-count').textContent = `${plural(rows.length, 'row')} of ${count(results.cells.length)}`;
}

function drawTable() {
  const shown = columns.filter(column => table.all || column.main);
  const head = column => el('th', { scope: 'col', class: column.head ? null : 'number' },
    el('button', { type: 'button', onclick: () => sortBy(column) }, column.label));
  byId('table-box').replaceChildren(el('table', { class: 'figures' },
    el('thead', null, el('tr', null, shown.map(head))), el('tbody')));
  drawRows();
}

function csv() {
  const quoted = value => /[",\r\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value;
  const line = values => values.map(value => quoted(String(value ?? ''))).join(',');
  const fields = columns.flatMap(column => column.fields);
  const rows = chosenCells().map(cell => line(fields.map(([, get]) => get(cell))));
  return [line(fields.map(([name]) => name)), ...rows, ''].join('\r\n');
}

function showTable() {
  const any = (word, names) => [['', `all ${word}`], ...names.map(name => [name, name])];
  const all = el('input', { type: 'checkbox', onchange: () => { table.all = all.checked; drawTable(); } });
  byId('table-controls').append(
    select('Scene', any('scenes', sceneNames), '', scene => { table.scene = scene; drawRows(); }),
    select('Budget', any('budgets', budgetNames), '', budget => { table.budget = budget; drawRows(); }),
    el('label', { class: 'check' }, all, el('span', null, 'All columns')),
    el('span', { id: 'table-count', class: 'soft', role: 'status' }),
    ...copyButton('Copy as CSV', csv));
  drawTable();
}
