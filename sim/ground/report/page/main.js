// The page of a flight, from report.json and the pictures beside it in the page.

import { html } from './text.js';
import { sections } from './sections.js';

const footer = ({ copies }) => html`<footer class="note"><p>Beside this page: <code>report.json</code> (all numbers), <code>model.${copies ? 'ply' : 'glb'}</code> (surface; ${copies ? 'MeshLab, CloudCompare, Blender' : 'Blender, browsers'}), <code>colmap/</code> (poses and points; COLMAP: File, Import model), <code>height.${copies ? 'pfm' : 'tif'}</code> and <code>ortho.png</code> (regular grid in the strip's world, <code>ortho.pgw</code> places it), <code>keyframes/</code> (decoded images, depths, masks). Further strips carry <code>-strip-N</code> in their names.</p></footer>\n`;

const embedded = (id) => JSON.parse(document.getElementById(id).textContent);
const report = embedded('report');
document.querySelector('main').innerHTML = html`${sections(report, embedded('pictures'))}${footer(report)}`.toString();
