// The flight as the viewer's page reads it from what it carries, as JSON without its arrays: viewer_flight.mjs VIEWER.html

import { readFileSync } from 'node:fs';

const page = readFileSync(process.argv[2], 'utf8');
globalThis.document = {
  getElementById(id) {
    const tag = `<script type="application/json" id="${id}">`;
    const begin = page.indexOf(tag) + tag.length;
    return { textContent: page.slice(begin, page.indexOf('</script>', begin)) };
  },
};
const script = readFileSync('sim/ground/viewer/data.js', 'utf8');
const { readFlight } = await import(`data:text/javascript,${encodeURIComponent(script)}`);
const { byId, ...flight } = readFlight();
for (const strip of flight.strips) strip.members = strip.members.length;
process.stdout.write(JSON.stringify(flight, (_, value) => (ArrayBuffer.isView(value) ? undefined : value)));
