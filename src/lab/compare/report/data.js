// The results as `phototaxis compare` wrote them, and how figures and elements are made of them.

const results = JSON.parse(document.getElementById('results').textContent);

const byId = id => document.getElementById(id);

/** An element; attributes that begin with `on` are listeners, those that are false or missing are left out. */
function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (typeof value === 'function') node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, '');
    else if (value !== false && value != null) node.setAttribute(name, value);
  }
  node.append(...children.flat().filter(child => child != null));
  return node;
}

const UNDEFINED = '–';

/** Three significant digits. */
function figure(value) {
  if (value == null) return UNDEFINED;
  const rounded = Number(value.toPrecision(3));
  const size = Math.abs(rounded);
  if (size >= 1e6 || (size > 0 && size < 1e-3)) return value.toExponential(2).replace('e+', 'e');
  if (size >= 1000) return Math.round(value).toLocaleString('en-GB');
  return size === 0 ? '0' : rounded.toPrecision(3);
}

/** A count, to the last digit. */
const count = value => value == null ? UNDEFINED : value.toLocaleString('en-GB');

/** The intervals' confidence in per cent, without zeros at its end. */
const confidence = `${Number((100 * results.confidence).toPrecision(6))} %`;

const times = value => value == null ? UNDEFINED : `${figure(value)}×`;

const hasInterval = measure => measure != null && measure.low != null && measure.high != null;

const interval = measure => hasInterval(measure) ? `${figure(measure.low)} to ${figure(measure.high)}` : 'no interval';

/** What an interval of a ratio says of it. */
function verdict(ratio) {
  if (!hasInterval(ratio)) return 'unknown';
  if (ratio.low > 1) return 'better';
  return ratio.high < 1 ? 'worse' : 'undecided';
}

const keyOf = (scene, method, budget) => JSON.stringify([scene, method, budget]);

const cells = new Map(results.cells.map(cell => [keyOf(cell.scene, cell.method, cell.budget), cell]));

const sceneNames = results.scenes.map(scene => scene.name);
const methodNames = results.methods.map(method => method.name);
const budgetNames = results.budgets.map(budget => budget.name);

/** What must be said of a cell beside its figures, in words. */
function flags(cell) {
  const said = [];
  if (cell.bias.biased) said.push('biased');
  if (cell.non_finite > 0) said.push(`not finite: ${count(cell.non_finite)}`);
  return said;
}

/** "a", "a and b", "a, b and c". */
function listed(words) {
  return words.length < 2 ? words.join('') : `${words.slice(0, -1).join(', ')} and ${words.at(-1)}`;
}

const plural = (n, word) => `${count(n)} ${word}${n === 1 ? '' : 's'}`;

/** A button that copies what `text` gives, and a place where it says whether it could. */
function copyButton(label, text) {
  const status = el('span', { role: 'status', class: 'status' });
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(text());
      status.textContent = 'Copied.';
    } catch {
      status.textContent = 'The browser does not let this page copy.';
    }
  };
  return [el('button', { type: 'button', onclick: copy }, label), status];
}

/** Radio buttons in a row; `chosen` is told the new value. */
function choice(name, legend, options, first, chosen) {
  const radio = ([value, label]) => el('label', null,
    el('input', { type: 'radio', name, value, checked: value === first, onchange: () => chosen(value) }),
    el('span', null, label));
  return el('fieldset', { class: 'choice' }, el('legend', null, legend), options.map(radio));
}

/** A drop-down list. */
function select(label, options, first, chosen) {
  const option = ([value, text]) => el('option', { value, selected: value === first }, text);
  const list = el('select', { onchange: () => chosen(list.value) }, options.map(option));
  return el('label', { class: 'select' }, el('span', null, label), list);
}

/** Tabs (arrow keys, Home and End go round) over the panel with the id `panel(index)`. */
function tabs(label, names, panel, chosen) {
  const choose = (index, focus) => {
    buttons.forEach((button, i) => {
      button.setAttribute('aria-selected', i === index);
      button.tabIndex = i === index ? 0 : -1;
    });
    if (focus) buttons[index].focus();
    chosen(index);
  };
  const onkeydown = event => {
    const now = buttons.indexOf(document.activeElement);
    const to = { ArrowRight: now + 1, ArrowLeft: now - 1, Home: 0, End: names.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    choose((to + names.length) % names.length, true);
  };
  const buttons = names.map((name, i) => el('button', {
    type: 'button', role: 'tab', 'aria-controls': panel(i), onclick: () => choose(i, false),
  }, name));
  choose(0, false);
  return el('div', { role: 'tablist', 'aria-label': label, class: 'tabs', onkeydown }, buttons);
}
