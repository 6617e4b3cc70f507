// The page of a flight, from report.json and the pictures beside it in the page, or of a comparison.

import { html } from './text.js';
import { sections } from './sections.js';
import { comparison } from './comparison.js';
import './zoom.js';

const footer = ({ copies }) => html`<footer class="note"><p>Beside this page: <code>report.json</code> (all numbers), <code>model.${copies ? 'ply' : 'glb'}</code> (surface; ${copies ? 'MeshLab, CloudCompare, Blender' : 'Blender, browsers'}), <code>colmap/</code> (poses and points; COLMAP: File, Import model), <code>height.${copies ? 'pfm' : 'tif'}</code> and <code>ortho.png</code> (regular grid in the strip's world, <code>ortho.pgw</code> places it), <code>keyframes/</code> (decoded images, depths, masks). Further strips carry <code>-strip-N</code> in their names.</p></footer>\n`;

const embedded = (id) => JSON.parse(document.getElementById(id)?.textContent ?? null);
const [report, compared] = [embedded('report'), embedded('comparison')];
document.querySelector('main').innerHTML = html`${compared ? comparison(compared) : [sections(report, embedded('pictures')), footer(report)]}`.toString();
