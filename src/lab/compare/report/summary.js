// What came out, in words, and how to come by it again.

const others = methodNames.filter(name => name !== results.baseline);

/** Cells of a scene and budget with a ratio to the baseline, the best first. */
function ranked(scene, budget) {
  return others.map(method => cells.get(keyOf(scene, method, budget)))
    .filter(cell => cell?.ratio.value != null)
    .sort((a, b) => b.ratio.value - a.ratio.value);
}

function told(cell) {
  const sure = { undecided: ', not told from 1', unknown: '' }[verdict(cell.ratio)] ?? '';
  const biased = cell.bias.biased ? ', biased' : '';
  return `${cell.method} ${times(cell.ratio.value)} (${interval(cell.ratio)}${sure}${biased})`;
}

function sceneLine(scene, budget) {
  const all = ranked(scene, budget);
  if (all.length === 0) return el('li', null, el('strong', null, scene), ': no ratio is defined');
  const rest = all.length > 1 ? `; worst ${told(all.at(-1))}` : '';
  return el('li', null, el('strong', null, scene), `: ${all.length > 1 ? 'best ' : ''}${told(all[0])}${rest}`);
}

const overallOf = (method, budget) => (results.overall ?? []).find(o => o.method === method && o.budget === budget);

/** The geometric mean over scenes, how sure it is, and apart from that how much scenes differ. */
function overallLine({ method, ratio }) {
  const ends = [ratio.least, ratio.most].map(end => `${times(end.value)} in ${end.scene}`).join(' to ');
  const missing = ratio.left_out.length > 0 ? `; without ${listed(ratio.left_out)}` : '';
  return el('li', null, el('strong', null, `${method} over ${plural(ratio.scenes, 'scene')}`),
    `: geometric mean ${times(ratio.value)} (${interval(ratio)}, by the runs’ spread); from scene to scene it varies by a factor of`
    + ` ${figure(ratio.spread)}, from ${ends}${missing}`);
}

/** "grid in door at 5 s and 10 s", for each scene and method that any of `found` belong to. */
function places(found) {
  const at = new Map();
  for (const cell of found) {
    const place = `${cell.method} in ${cell.scene}`;
    at.set(place, [...(at.get(place) ?? []), cell.budget]);
  }
  return [...at].map(([place, budgets]) => `${place} at ${listed(budgets)}`).join('; ');
}

function warnings() {
  const lines = [];
  const warn = (head, found, tail) => {
    if (found.length === 0) return;
    lines.push(el('p', { class: 'warning' }, el('strong', null, head), ` ${places(found)}. ${tail}`));
  };
  const tested = results.cells.filter(cell => cell.bias.biased != null);
  const biased = tested.filter(cell => cell.bias.biased);
  warn('Biased:', biased, 'More time does not take such an error away: the efficiency of a biased method says little.');
  warn('Not finite:', results.cells.filter(cell => cell.non_finite > 0), '');
  if (biased.length > 0) return lines;
  const said = tested.length > 0
    ? `No bias was found in the ${plural(tested.length, 'cell')} that could be tested.`
    : 'No cell could be tested for bias.';
  return [...lines, el('p', null, said)];
}

function opening(budget) {
  if (results.cells.length === 0) return 'No run has ended yet.';
  const runs = results.cells.map(cell => cell.runs);
  const [least, most] = [Math.min(...runs), Math.max(...runs)];
  const ran = least === most ? `${plural(most, 'run')} each` : `${least} to ${plural(most, 'run')} each`;
  const over = `${plural(others.length, 'method')} against ${results.baseline} in`
    + ` ${plural(sceneNames.length, 'scene')}, under ${plural(budgetNames.length, 'budget')}, ${ran}.`;
  const all = sceneNames.flatMap(scene => ranked(scene, budget)).sort((a, b) => b.ratio.value - a.ratio.value);
  if (all.length === 0) return `${over} No ratio to ${results.baseline} is defined.`;
  const [best, worst] = [all[0], all.at(-1)];
  if (best === worst) return `${over} At ${budget}, efficiency over that of ${results.baseline}: ${told(best)}.`;
  return `${over} At ${budget}, efficiency over that of ${results.baseline} is highest for ${told(best)} in`
    + ` ${best.scene}, lowest for ${told(worst)} in ${worst.scene}.`;
}

function showSummary() {
  document.title = results.title;
  byId('title').textContent = results.title;
  const budget = budgetNames.at(-1);
  const { cpu, threads, os } = results.machine;
  const scenes = sceneNames.map(scene => sceneLine(scene, budget));
  const means = others.map(method => overallOf(method, budget)).filter(mean => mean?.ratio.scenes > 1);
  const { commit, compiled_for: built, embree, embree_isa: isa } = results.platform ?? {};
  const made = results.platform
    ? ` Commit ${commit ?? 'unknown'}, compiled for ${built}; Embree ${embree} with ${isa}; ${results.date}.` : '';
  byId('summary').append(
    el('p', { class: 'lead' }, opening(budget)),
    ...(means.length > 0 ? [el('ul', null, means.map(overallLine))] : []),
    ...(scenes.length > 1 ? [el('ul', null, scenes)] : []),
    ...warnings(),
    el('p', { class: 'soft' }, `Phototaxis ${results.version} with ${plural(threads, 'thread')} on ${cpu}, ${os}.${made}`),
    el('div', { class: 'command' }, el('code', null, results.command),
      ...copyButton('Copy command', () => results.command)),
  );
}

const setting = value => typeof value === 'string' ? value : JSON.stringify(value);

function overrides(method) {
  const said = Object.entries(method.overrides).map(([key, value]) => `${key} = ${setting(value)}`);
  return said.length > 0 ? said.join(', ') : 'the scene’s own settings';
}

/** A comparison that was stopped early may have no reference yet. */
function referenceRow({ name, path, width, height, triangles, reference }) {
  const source = { made: 'made for this: ', file: 'given: ' }[reference?.source] ?? 'none';
  return [name, path, `${width} × ${height}`, count(triangles), source + (reference?.path ?? ''),
    count(reference?.samples), figure(reference?.wall_seconds), figure(reference?.relmse_noise)];
}

function simpleTable(caption, heads, rows) {
  const row = ([first, ...rest]) => el('tr', null, el('th', { scope: 'row' }, first),
    rest.map(text => el('td', null, text)));
  const table = el('table', { class: 'plain' }, el('caption', null, caption),
    el('thead', null, el('tr', null, heads.map(head => el('th', { scope: 'col' }, head)))),
    el('tbody', null, rows.map(row)));
  return el('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': caption }, table);
}

function showSetup() {
  const methods = results.methods.map(method => [
    method.baseline ? `${method.name} (baseline)` : method.name, overrides(method)]);
  byId('setup').append(
    simpleTable('Methods', ['Method', 'Settings'], methods),
    simpleTable('Scenes and references', ['Scene', 'File', 'Pixels', 'Triangles', 'Reference', 'Samples per pixel',
      'Seconds', 'Its own relMSE'], results.scenes.map(referenceRow)),
  );
  byId('intervals').textContent = `At a confidence of ${confidence}, over runs that differ by`
    + ' their seed alone; none where there is one run.';
}
