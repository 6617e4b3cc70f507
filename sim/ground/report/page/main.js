// The page of a flight, from report.json and the pictures beside it in the page.

import { html } from './text.js';
import { overview } from './overview.js';
import { joined, control, fixes, strips, landing, accuracy } from './strips.js';
import { problems, files } from './problems.js';
import { score } from './score.js';
import { keyframeTable, gallery } from './keyframes.js';
import { captures } from './captures.js';
import { alongTheFlight, cost } from './costs.js';

const footer = ({ copies }) => html`<footer class="note"><p>Beside this page: <code>report.json</code> (all numbers), <code>model.${copies ? 'ply' : 'glb'}</code> (surface; ${copies ? 'MeshLab, CloudCompare, Blender' : 'Blender, browsers'}), <code>colmap/</code> (poses and points; COLMAP: File, Import model), <code>height.${copies ? 'pfm' : 'tif'}</code> and <code>ortho.png</code> (regular grid in the strip's world, <code>ortho.pgw</code> places it), <code>keyframes/</code> (decoded images, depths, masks). Further strips carry <code>-strip-N</code> in their names.</p></footer>\n`;

const sections = [overview, joined, control, fixes, strips, landing, problems, score, accuracy, keyframeTable, captures, alongTheFlight, cost,
  gallery, files, footer];
/// The text of the page's <main>.
export const page = (report, pictures) => html`${sections.map((section) => section(report, pictures))}`.toString();

const embedded = (id) => JSON.parse(document.getElementById(id).textContent);
document.querySelector('main').innerHTML = page(embedded('report'), embedded('pictures'));
