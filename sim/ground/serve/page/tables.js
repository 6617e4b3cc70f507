// Texts of the page. What came down is only ever set as text, never as markup.

export function make(tag, text = '', kind = '') {
  const element = document.createElement(tag);
  if (text !== '') element.textContent = text;
  if (kind) element.className = kind;
  return element;
}

export function bytes(count) {
  if (count < 1000) return `${count} B`;
  if (count < 1e6) return `${(count / 1e3).toPrecision(3)} kB`;
  return `${(count / 1e6).toPrecision(3)} MB`;
}

export const seconds = (value) => (value === undefined || value === null ? '–' : `${value.toFixed(1)} s`);
export const milliseconds = (value_s) => `${(value_s * 1e3).toFixed(2)} ms`;
const ratio = (value) => (value === undefined || value === null ? '–' : value.toFixed(2));
const percent = (value) => (value === undefined || value === null ? '–' : `${(100 * value).toFixed(1)} %`);

export function facts(parent, pairs) {
  parent.replaceChildren(...pairs.map(([name, value, kind]) => {
    const box = make('div');
    box.append(make('dt', name), make('dd', value, kind ?? ''));
    return box;
  }));
}

function row(cells, tag) {
  const tr = make('tr');
  tr.append(...cells.map(([text, kind]) => make(tag, text, kind)));
  return tr;
}

const product = (item) => (item && item[0] > 0 ? `${bytes(item[0])}, ${item[1]}${item[2] ? `/${item[2]}` : ''}` : '–');

function keyframeRow(id, k) {
  return row([[String(id)], [k.n, 't'], [seconds(k.t)], [k.v, 't'], [percent(k.o)], [ratio(k.r)],
    [product(k.i)], [product(k.d)]], 'td');
}

const keyframeHead = [['keyframe'], ['frame', 't'], ['time'], ['state', 't'], ['overlap'], ['richness'],
  ['image, layers'], ['depth, layers']];

// A row is made again only when its keyframe has changed.
export class KeyframeTable {
  constructor(table, more) {
    this.table = table;
    this.more = more;
    this.most = 50;
    this.rows = new Map();
    more.addEventListener('click', () => { this.most += 200; this.show(this.list); });
  }

  show(list) {
    this.list = list;
    const shown = list.slice(-this.most).reverse();
    const rows = new Map();
    for (const [id, k] of shown) {
      const old = this.rows.get(id);
      rows.set(id, old && old.item === k ? old : { item: k, element: keyframeRow(id, k) });
    }
    this.rows = rows;
    const head = shown.length ? [row(keyframeHead, 'th')] : [];
    this.table.replaceChildren(...head, ...[...rows.values()].map((r) => r.element));
    this.more.hidden = list.length <= this.most;
  }
}

const severityKind = ['', '', 'warn', 'bad'];

export function showEvents(parent, list, least) {
  const shown = list.filter(([, e]) => e.s >= least).slice(-200).reverse();
  if (shown.length === 0) {
    parent.replaceChildren(make('li', 'No event of this severity has come down.', 'note'));
    return;
  }
  parent.replaceChildren(...shown.map(([, e]) => {
    const item = make('li');
    item.append(`${seconds(e.t)} `, make('b', e.severity, severityKind[e.s] ?? ''), ` ${e.text}`);
    if (e.advice && e.s >= 2) item.append(make('p', e.advice, 'note'));
    return item;
  }));
}

export function showComponents(table, list) {
  const head = [['component', 't'], ['steps'], ['faults'], ['restarts'], ['overruns'], ['busy'], ['longest step']];
  const rows = list.map(([, c]) => row([[c.n, 't'], [String(c.steps)], [String(c.faults)], [String(c.restarts)],
    [String(c.overruns)], [milliseconds(c.busy_s)], [milliseconds(c.longest_s)]], 'td'));
  table.replaceChildren(...(list.length ? [row(head, 'th')] : []), ...rows);
}

export function showList(parent, lines, none) {
  parent.replaceChildren(...(lines.length ? lines : [none]).map((line) => {
    const item = make('li');
    item.append(line);
    return item;
  }));
}

export function link(name) {
  const a = make('a', name);
  a.href = `/files/${name.split('/').map(encodeURIComponent).join('/')}`;
  return a;
}
