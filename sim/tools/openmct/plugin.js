// A plugin for Open MCT: the flight of an ilp-ground serve, from its server-sent events. It has keyframes, events and
// storage as telemetry in mission time, which is seconds since the mission's epoch.

const space = 'ilp';
const id = (key) => ({ namespace: space, key });
const value = (key, name, unit, more = {}) => ({ key, name, unit, format: 'number', hints: { range: 1 }, ...more });
const text = (key, name) => ({ key, name, format: 'string' });
const time = { key: 'mission', source: 't', name: 'Mission time', unit: 's', format: 'mission-time', hints: { domain: 1 } };

// What each telemetry point holds; items have the names and fields of report.json.
const points = {
  keyframes: {
    name: 'Keyframes',
    prefix: 'keyframes/',
    values: [value('keyframe', 'Keyframe'), value('strip', 'Strip'), value('overlap', 'Overlap', '1'), value('richness', 'Richness', '1'),
      value('error', 'Reprojection error', 'px'), value('x', 'x'), value('y', 'y'), value('z', 'z'),
      value('image_bytes', 'Image', 'B'), value('depth_bytes', 'Depth', 'B')],
    row: (number, k) => {
      const pose = k.pose?.state === 'final' ? k.pose : { centre: [] };
      const [x, y, z] = pose.centre;
      return { t: k.time_ns === null ? NaN : k.time_ns / 1e9, keyframe: number, strip: k.strip, overlap: k.index > 0 ? k.overlap_with_previous : undefined,
        richness: k.richness?.index, error: pose.rms_px, x, y, z, image_bytes: k.image_product?.bytes, depth_bytes: k.depth_product?.bytes };
    },
  },
  events: {
    name: 'Events',
    prefix: 'events/',
    values: [value('event', 'Event'), value('level', 'Severity'), text('severity', 'Severity in words'), text('name', 'Name'),
      text('component', 'Component'), text('text', 'What happened'), text('advice', 'What to do')],
    row: (number, e) => ({ t: e.time_ns / 1e9, event: number, level: e.level, severity: e.severity, name: e.name, component: e.component, text: e.text, advice: e.advice }),
  },
  storage: {
    name: 'Storage',
    values: [value('frame_bytes', 'Frames', 'B'), value('depth_bytes', 'Depth', 'B'), value('structure_bytes', 'Structure', 'B'),
      value('product_bytes', 'Products', 'B'), value('budget_bytes', 'Budget', 'B'), value('database_bytes', 'Database', 'B'),
      value('products_held', 'Products held'), value('products_acknowledged', 'Products acknowledged'),
      value('products_dropped', 'Products dropped')],
  },
};

/** The items of the server, and the rows that follow from them. */
class Flight {
  constructor(url) {
    this.items = new Map();
    this.rows = { keyframes: new Map(), events: new Map(), storage: new Map() };
    this.listeners = new Set();
    this.stream = new EventSource(url);
    this.stream.onmessage = (message) => this.take(JSON.parse(message.data));
    this.ready = new Promise((done) => { this.isReady = done; });
  }

  take({ full, set, gone }) {
    if (full) {
      this.items.clear();
      for (const rows of Object.values(this.rows)) rows.clear();
    }
    for (const name of gone) this.items.delete(name);
    for (const [name, item] of Object.entries(set)) this.items.set(name, item);
    for (const [key, point] of Object.entries(points)) {
      if (!point.prefix) continue;
      for (const name of gone) if (name.startsWith(point.prefix)) this.rows[key].delete(Number(name.slice(point.prefix.length)));
      for (const [name, item] of Object.entries(set)) {
        if (!name.startsWith(point.prefix)) continue;
        const number = Number(name.slice(point.prefix.length));
        const row = point.row(number, item);
        if (Number.isFinite(row.t)) this.put(key, number, row);
      }
    }
    // The record of the storage has no time of its own: it is that of the newest keyframe.
    if (set.storage) {
      const latest = Math.max(...[...this.rows.keyframes.values()].map((row) => row.t));
      if (Number.isFinite(latest)) this.put('storage', latest, { t: latest, ...set.storage });
    }
    this.isReady();
  }

  put(key, number, row) {
    this.rows[key].set(number, row);
    for (const listener of this.listeners) if (listener.key === key) listener.tell(row);
  }

  async between(key, start, end) {
    await this.ready;
    return [...this.rows[key].values()].filter((row) => row.t >= start && row.t <= end).sort((a, b) => a.t - b.t);
  }
}

/** `url` is where /events of ilp-ground serve is found, from the page. */
export function flightPlugin(url = '/events') {
  return (openmct) => {
    const flight = new Flight(url);
    openmct.telemetry.addFormat({
      key: 'mission-time',
      format: (seconds) => `${Number(seconds).toFixed(3)} s`,
      parse: (shown) => (typeof shown === 'number' ? shown : parseFloat(shown)),
      validate: (shown) => Number.isFinite(parseFloat(shown)),
    });
    openmct.time.addTimeSystem({ key: 'mission', name: 'Mission time', cssClass: 'icon-clock', timeFormat: 'mission-time', isUTCBased: false });
    openmct.types.addType('ilp.telemetry', { name: 'Telemetry of the flight', description: 'From ilp-ground serve', cssClass: 'icon-telemetry' });
    openmct.objects.addRoot(id('flight'));
    openmct.objects.addProvider(space, {
      get: async ({ key }) => (key === 'flight'
        ? { identifier: id(key), name: 'Flight', type: 'folder', location: 'ROOT' }
        : { identifier: id(key), name: points[key].name, type: 'ilp.telemetry', location: `${space}:flight`,
          telemetry: { values: [...points[key].values, time] } }),
    });
    openmct.composition.addProvider({
      appliesTo: (object) => object.identifier.namespace === space && object.type === 'folder',
      load: async () => Object.keys(points).map(id),
    });
    openmct.telemetry.addProvider({
      supportsRequest: (object) => object.type === 'ilp.telemetry',
      supportsSubscribe: (object) => object.type === 'ilp.telemetry',
      request: (object, { start, end }) => flight.between(object.identifier.key, start, end),
      subscribe: (object, tell) => {
        const listener = { key: object.identifier.key, tell };
        flight.listeners.add(listener);
        return () => flight.listeners.delete(listener);
      },
    });
  };
}
