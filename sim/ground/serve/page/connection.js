// Keeps the state of the flight: an item by each name. The server sends what has changed, after a break of the
// connection too.

const silence_ms = 15000;  // the server speaks every 5 s

export class Connection {
  // changed(names) after every update, told(text, class) when the connection comes or goes.
  constructor(changed, told) {
    this.items = new Map();
    this.updates = 0;
    this.bytes = 0;
    this.changed = changed;
    this.told = told;
    this.heard = Date.now();
    this.lost = null;
    this.open();
    setInterval(() => { if (Date.now() - this.heard > silence_ms) this.reopen(); }, 1000);
  }

  open() {
    this.stream = new EventSource('/events');
    this.stream.onmessage = (message) => this.take(message.data);
    this.stream.addEventListener('alive', () => this.alive());
    this.stream.onopen = () => this.alive();
    this.stream.onerror = () => {
      this.gone();
      // After an answer that is no stream a browser does not try again by itself.
      if (this.stream.readyState === EventSource.CLOSED) setTimeout(() => this.reopen(), 2000);
    };
  }

  reopen() {
    this.gone();
    this.stream.close();
    this.heard = Date.now();
    this.open();
  }

  alive() {
    this.heard = Date.now();
    this.lost = null;
    this.told('connected', 'good');
  }

  gone() {
    this.lost ??= new Date();
    this.told(`not connected since ${this.lost.toLocaleTimeString()}; trying again`, 'bad');
  }

  take(text) {
    this.alive();
    const update = JSON.parse(text);
    const names = new Set([...Object.keys(update.set), ...update.gone]);
    if (update.full) {
      for (const name of this.items.keys()) names.add(name);
      this.items.clear();
    }
    for (const [name, item] of Object.entries(update.set)) this.items.set(name, item);
    for (const name of update.gone) this.items.delete(name);
    this.updates += 1;
    this.bytes += text.length;
    if (names.size > 0) this.changed(names);
  }

  // Of items figures/NAME, by name.
  figures() { return Object.fromEntries([...this.items].filter(([name]) => name.startsWith('figures/')).map(([name, item]) => [name.slice(8), item])); }

  // report.json again, of items KEY, KEY/NUMBER and KEY/PART/NUMBER.
  report() {
    const report = {};
    const lists = new Set();
    for (const [name, item] of this.items) {
      if (name.startsWith('figures/')) continue;
      if (name.includes('/')) lists.add(name.slice(0, name.lastIndexOf('/')));
      else report[name] = item;
    }
    for (const list of lists) {
      const [key, part] = list.split('/');
      const elements = this.all(list).map(([, item]) => item);
      report[key] = part ? { ...report[key], [part]: elements } : elements;
    }
    return report;
  }

  get(name) { return this.items.get(name); }

  // [number, item] of all items "KIND/NUMBER", by number.
  all(kind) {
    const list = [];
    for (const [name, item] of this.items) {
      if (name.startsWith(`${kind}/`)) list.push([Number(name.slice(kind.length + 1)), item]);
    }
    return list.sort((a, b) => a[0] - b[0]);
  }
}
