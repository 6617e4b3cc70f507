// The page of a comparison of the map with another terrain model.

import { html, table, brief, counted } from './text.js';
import { plots } from './plot.js';
import { figureOf, legend } from './figures.js';

/// The outline of the bars.
const outline = ({ low_m: low, bin_m: width, counts }) => counts.flatMap((n, i) => [[low + i * width, n], [low + (i + 1) * width, n]]);

export const comparison = ({ title, lines, histogram, picture, exaggeration }) => html`<header><p class="kicker">Comparison</p><h1>${title}</h1></header>
${table([['Figure', 't'], ['Value', 't w']], lines.map((line) => line.match(/^(\S+)\s*(.*)$/s).slice(1)))}
<h2>Map minus other model</h2>
${figureOf(picture, {
    label: 'height difference in colours over the shaded ground', unit: 'm', frame: legend(picture, 'Map minus other model, m'),
    caption: `Colours: height of the map minus height of the other model after alignment. The range holds 95 % of the cells. Shades: the ground of the map, lit from the upper left (slopes ${brief(exaggeration)} times steeper than they are). Blank: not compared.`,
  })}${plots([{
    title: `Height differences; ${counted(histogram.outside, 'cell')} outside of the plot`, x: 'map minus other model, m', y: 'cells', counts: false,
    series: [{ name: 'cells', style: 's1', mark: 'curve', points: outline(histogram) }],
  }])}<footer class="note"><p>Beside this page: <code>difference.tif</code>, <code>difference.png</code>, <code>comparison.json</code>.</p></footer>\n`;
