// The charts, by scene. Each stands in a shadow tree, so that ids within one drawing mean nothing to another. What is drawn has a class
// for its colour, and the page says which colour that is on light and on dark paper.

const inks = ['ink', 'faint', 'grid', 'paper', 'm0', 'm1', 'm2', 'm3', 'm4', 'm5', 'm6', 'm7'];

const inkRules = inks.map(name => `.f-${name} { fill: var(--chart-${name}); } .s-${name} { stroke: var(--chart-${name}); }`);

function drawing(svg, size) {
  const parsed = new DOMParser().parseFromString(svg, 'image/svg+xml').documentElement;
  if (parsed.localName !== 'svg') return el('p', null, 'This chart cannot be read.');
  const host = el('div', { class: `drawing ${size}` });
  const style = el('style', null, 'svg { display: block; width: 100%; height: auto; }', inkRules.join(' '));
  host.attachShadow({ mode: 'open' }).append(style, document.importNode(parsed, true));
  return host;
}

/** Wide, and for phones a narrow one in its place. */
function chart({ id, title, svg, narrow }) {
  return el('figure', { class: 'chart', id: `chart-${id}`, 'aria-label': title }, drawing(svg, 'wide'),
    drawing(narrow ?? svg, 'narrow'));
}

function showCharts() {
  const section = byId('charts');
  const groups = [['All scenes', results.charts.filter(c => c.scene == null)],
    ...sceneNames.map(name => [name, results.charts.filter(c => c.scene === name)])]
    .filter(([, charts]) => charts.length > 0);
  if (groups.length === 0) {
    section.append(el('p', null, 'These results hold no charts.'));
    return;
  }
  const panelId = index => `charts-panel-${index}`;
  const panels = groups.map(([name, charts], i) => el('div', { id: panelId(i), role: 'tabpanel', 'aria-label': name },
    el('h3', { class: 'print-only' }, name), el('div', { class: 'chart-grid' }, charts.map(chart))));
  const list = tabs('Charts of', groups.map(([name]) => name), panelId,
    index => panels.forEach((panel, i) => { panel.hidden = i !== index; }));
  section.append(list, ...panels);
}
