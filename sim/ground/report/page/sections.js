// The sections of the page of a flight, in the report and live.

import { overview } from './overview.js';
import { joined, control, fixes, strips, landing, accuracy } from './strips.js';
import { problems, files } from './problems.js';
import { score } from './score.js';
import { keyframeTable, gallery } from './keyframes.js';
import { captures } from './captures.js';
import { alongTheFlight, cost } from './costs.js';

/// Markup of each, from report.json and the pictures: figures by name, and by keyframe image, depth and mask.
export const sections = (report, pictures) => [overview, joined, control, fixes, strips, landing, problems, score, accuracy, keyframeTable, captures,
  alongTheFlight, cost, gallery, files].map((section) => section(report, pictures));
