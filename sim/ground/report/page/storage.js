// The storage on board, by its latest record.

import { bytesText, counted } from './text.js';

/// [name, value, class]
export const storageFacts = (s) => (!s ? [] : [
  ['Held', `${bytesText(s.frame_bytes + s.depth_bytes + s.structure_bytes + s.product_bytes)} of ${bytesText(s.budget_bytes)}`],
  ['Frames', bytesText(s.frame_bytes)], ['Depth maps', bytesText(s.depth_bytes)],
  ['Products', `${bytesText(s.product_bytes)} in ${s.products_held}`], ['Acknowledged', s.products_acknowledged],
  ['Given up', [counted(s.products_dropped, 'product'), counted(s.layers_cut, 'layer'), counted(s.frames_skipped, 'frame')].join(', '), s.products_dropped > 0 ? 'bad' : ''],
  ['Database', bytesText(s.database_bytes)],
  ...(s.times_full > 0 ? [['Was full', `${s.times_full} times`, 'warn']] : []),
]);
