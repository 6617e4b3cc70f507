// What the script of a page from ilp-ground writes, as HTML: page_text.mjs PAGE.html. The page's own script runs over the
// page's own data; of a browser there is only what it uses.

import { readFileSync } from 'node:fs';
import { runInNewContext } from 'node:vm';

const page = readFileSync(process.argv[2], 'utf8');
const contentOf = (tag) => {
  const begin = page.indexOf(tag) + tag.length;
  if (begin < tag.length) return null;
  return page.slice(begin, page.indexOf('</script>', begin));
};
const main = { innerHTML: '' };
const document = {
  title: page.match(/<title>(.*?)<\/title>/)?.[1],
  addEventListener() {},
  getElementById: (id) => ({ textContent: contentOf(`<script type="application/json" id="${id}">`) }),
  querySelector: (name) => (name === 'main' ? main : null),
};
runInNewContext(`'use strict';${contentOf('<script type="module">')}`, { document });
process.stdout.write(main.innerHTML);
