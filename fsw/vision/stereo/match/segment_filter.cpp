#include "fsw/vision/stereo/match/segment_filter.hpp"

#include <cmath>

namespace ilp {

void connect_segments_row(ImageView<const float> disparity_px, ImageView<const float> sigma_px, std::int32_t y,
                          float max_step_px, PixelForest& workspace) {
  std::int32_t* links = workspace.links.data();
  const std::int32_t width = disparity_px.width;
  const std::int32_t first = y * width;
  const float* d = disparity_px.row(y);
  const float* s = sigma_px.row(y);
  const float* d_above = disparity_px.row(y > 0 ? y - 1 : 0);
  const float* s_above = sigma_px.row(y > 0 ? y - 1 : 0);
  std::int32_t run = first;
  for (std::int32_t x = 0; x < width; ++x) {
    const std::int32_t pixel = first + x;
    if (x > 0 && s[x] > 0 && s[x - 1] > 0 && std::fabs(d[x] - d[x - 1]) <= max_step_px) {
      links[pixel] = run;
      --links[run];
    } else {
      links[pixel] = -1;
      run = pixel;
    }
  }
  if (y == 0) return;
  std::int32_t last_run = -1;
  std::int32_t last_above = -1;
  for (std::int32_t x = 0; x < width; ++x) {
    if (!(s[x] > 0 && s_above[x] > 0 && std::fabs(d[x] - d_above[x]) <= max_step_px)) continue;
    const std::int32_t here = root_of(links, first + x);
    const std::int32_t above = root_of(links, first - width + x);
    if (here == last_run && above == last_above) continue;
    join(links, here, above, 0);
    last_run = here;
    last_above = above;
  }
}

void remove_small_segments_row(ImageView<float> sigma_px, std::int32_t y, std::int32_t min_area_px,
                               PixelForest& workspace) {
  std::int32_t* links = workspace.links.data();
  float* s = sigma_px.row(y);
  for (std::int32_t x = 0; x < sigma_px.width; ++x) {
    if (s[x] > 0 && -links[root_of(links, y * sigma_px.width + x)] < min_area_px) s[x] = 0;
  }
}

}  // namespace ilp
