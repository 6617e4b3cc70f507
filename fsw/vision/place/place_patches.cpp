#include "fsw/vision/place/place_patches.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/features/harris.hpp"
#include "fsw/vision/features/harris_workspace.hpp"

namespace ilp {
namespace {

constexpr std::int32_t grey_steps = 15;
// Between the best whole pixel and the registered place.
constexpr float max_patch_refinement_px = 2;
constexpr std::int32_t side = place_patch_side;
constexpr std::int32_t padded_side = 16;
static_assert(side <= padded_side &&
              PlacePatchWorkspace::area_side - side + padded_side <= PlacePatchWorkspace::area_stride);
constexpr std::int32_t middle = kept_patch_side / 2 - 1;  // of a kept patch: the pixel at or before its place

/// Of a patch's place inside its kept pixels.
float inside(float coordinate) {
  return static_cast<float>(middle) + (coordinate - std::floor(coordinate));
}

bool prepare(const PlacePatch& patch, PlacePatchWorkspace& workspace) {
  const std::int32_t range = patch.brightest - patch.darkest;
  for (std::size_t i = 0; i < patch.steps.size(); ++i) {
    const std::int32_t low = patch.steps[i] & 15, high = patch.steps[i] >> 4;
    workspace.grey[2 * i] = static_cast<std::uint8_t>(patch.darkest + (low * range + grey_steps / 2) / grey_steps);
    workspace.grey[2 * i + 1] = static_cast<std::uint8_t>(patch.darkest + (high * range + grey_steps / 2) / grey_steps);
  }
  const GrayView kept(workspace.grey.data(), kept_patch_side, kept_patch_side);
  const ImageView<std::uint16_t> smoothed(workspace.smoothed.data(), kept_patch_side, kept_patch_side);
  smooth(kept, smoothed);
  return prepare_patch(smoothed, inside(patch.x), inside(patch.y), side, workspace.prepared);
}

/// Grey values in `grey_steps` steps from the darkest to the brightest.
void keep_pixels(GrayView image, std::int32_t left, std::int32_t top, PlacePatch& patch) {
  std::uint8_t lowest[kept_patch_side], highest[kept_patch_side];
  std::fill_n(lowest, kept_patch_side, std::uint8_t{255});
  std::fill_n(highest, kept_patch_side, std::uint8_t{0});
  for (std::int32_t row = 0; row < kept_patch_side; ++row) {
    const std::uint8_t* const from = image.row(top + row) + left;
    for (std::int32_t x = 0; x < kept_patch_side; ++x) {
      lowest[x] = from[x] < lowest[x] ? from[x] : lowest[x];
      highest[x] = from[x] > highest[x] ? from[x] : highest[x];
    }
  }
  patch.darkest = *std::min_element(lowest, lowest + kept_patch_side);
  patch.brightest = *std::max_element(highest, highest + kept_patch_side);
  const auto range = static_cast<std::uint32_t>(std::max(patch.brightest - patch.darkest, 1));
  // Dividends are below 2^12 and divisors below 2^8, so that the product with this is the quotient exactly.
  constexpr std::uint32_t bits = 20;
  const std::uint32_t inverse = ((1U << bits) + range - 1) / range, half = range / 2, darkest = patch.darkest;
  const auto step_of = [&](std::uint8_t grey) { return ((grey - darkest) * grey_steps + half) * inverse >> bits; };
  constexpr std::ptrdiff_t row_bytes = kept_patch_side / 2;
  std::uint8_t* const __restrict steps = patch.steps.data();
  for (std::int32_t row = 0; row < kept_patch_side; ++row) {
    const std::uint8_t* const from = image.row(top + row) + left;
    for (std::ptrdiff_t k = 0; k < row_bytes; ++k) {
      steps[row * row_bytes + k] = static_cast<std::uint8_t>(step_of(from[2 * k]) | step_of(from[2 * k + 1]) << 4U);
    }
  }
}

bool cut(GrayView image, const Corner& corner, PlacePatch& patch) {
  const auto left = static_cast<std::int32_t>(std::floor(corner.x)) - middle;
  const auto top = static_cast<std::int32_t>(std::floor(corner.y)) - middle;
  if (left < 0 || top < 0 || left + kept_patch_side > image.width || top + kept_patch_side > image.height) return false;
  patch.x = corner.x;
  patch.y = corner.y;
  with_widest_vectors([&] { keep_pixels(image, left, top, patch); });
  return true;
}

struct Prediction {
  float x = 0, y = 0;
  Linear2 linear;
};

/// False for a place beyond the horizon of the homography.
bool predict(const double (&h)[9], const PlacePatch& patch, Prediction& out) {
  const auto x = static_cast<double>(patch.x), y = static_cast<double>(patch.y);
  const double w = h[6] * x + h[7] * y + h[8];
  const double u = (h[0] * x + h[1] * y + h[2]) / w, v = (h[3] * x + h[4] * y + h[5]) / w;
  out.x = static_cast<float>(u);
  out.y = static_cast<float>(v);
  out.linear = {static_cast<float>((h[0] - u * h[6]) / w), static_cast<float>((h[1] - u * h[7]) / w),
                static_cast<float>((h[3] - v * h[6]) / w), static_cast<float>((h[4] - v * h[7]) / w)};
  return std::isfinite(u) && std::isfinite(v) && std::fabs(u) < 1e5 && std::fabs(v) < 1e5 &&
         std::fabs(out.linear.xx) < 4 && std::fabs(out.linear.xy) < 4 && std::fabs(out.linear.yx) < 4 &&
         std::fabs(out.linear.yy) < 4;
}

/// The part of an image about a prediction, smoothed.
struct Window {
  SmoothView view;
  std::int32_t left = 0, top = 0;
};

/// How often [1 2 1]/4 must smooth an image whose pixels are finer than the patch's by `linear`, so that both show the
/// ground equally sharp: a pixel and one smoothing have a variance of 7/12 of a pixel squared, each more adds 1/2.
std::int32_t passes_to_sharpness(const Linear2& linear) {
  constexpr std::int32_t most = 8;
  const float area = std::fabs(linear.xx * linear.yy - linear.xy * linear.yx);
  return std::clamp(static_cast<std::int32_t>(std::floor((area - 1) * (7.0F / 6) + 0.5F)), 0, most);
}

/// [1 2 1]/4 in x and y, in place. Sums of smoothed values have 16 bits.
void smooth_again(ImageView<std::uint16_t> image, PlacePatchWorkspace& workspace) {
  const auto sum_row = [&](std::int32_t y) {
    const std::uint16_t* const from = image.row(std::clamp(y, 0, image.height - 1));
    std::uint16_t* const to = workspace.row_sums[static_cast<std::size_t>(y + 1) % 3].data();
    const std::int32_t last = image.width - 1;
    for (std::int32_t x = 1; x < last; ++x) to[x] = static_cast<std::uint16_t>(from[x - 1] + 2 * from[x] + from[x + 1]);
    to[0] = static_cast<std::uint16_t>(3 * from[0] + from[1]);
    to[last] = static_cast<std::uint16_t>(3 * from[last] + from[last - 1]);
  };
  sum_row(-1);
  sum_row(0);
  for (std::int32_t y = 0; y < image.height; ++y) {
    if (y + 1 < image.height) {
      sum_row(y + 1);
    } else {
      workspace.row_sums[static_cast<std::size_t>(y + 2) % 3] = workspace.row_sums[static_cast<std::size_t>(y + 1) % 3];
    }
    const std::uint16_t* const above = workspace.row_sums[static_cast<std::size_t>(y) % 3].data();
    const std::uint16_t* const here = workspace.row_sums[static_cast<std::size_t>(y + 1) % 3].data();
    const std::uint16_t* const below = workspace.row_sums[static_cast<std::size_t>(y + 2) % 3].data();
    std::uint16_t* const to = image.row(y);
    for (std::int32_t x = 0; x < image.width; ++x)
      to[x] = static_cast<std::uint16_t>((above[x] + 2 * here[x] + below[x] + 8) >> 4);
  }
}

bool cut_window(GrayView image, const Prediction& at, std::int32_t radius_px, PlacePatchWorkspace& workspace,
                Window& window) {
  const Linear2& l = at.linear;
  const float widest = std::max(std::fabs(l.xx) + std::fabs(l.xy), std::fabs(l.yx) + std::fabs(l.yy));
  // Registration may move the patch and change its shape a little.
  const std::int32_t from_middle = side / 2 + radius_px + 3;
  const auto reach = static_cast<std::int32_t>(std::ceil(widest * static_cast<float>(from_middle))) + 3;
  const auto x = static_cast<std::int32_t>(std::floor(at.x)), y = static_cast<std::int32_t>(std::floor(at.y));
  window.left = std::max(x - reach, 0);
  window.top = std::max(y - reach, 0);
  const std::int32_t width = std::min(x + reach + 1, image.width - 1) - window.left + 1;
  const std::int32_t height = std::min(y + reach + 1, image.height - 1) - window.top + 1;
  if (width < side || height < side || width > PlacePatchWorkspace::window_side ||
      height > PlacePatchWorkspace::window_side) {
    return false;
  }
  const ImageView<std::uint16_t> smoothed(workspace.window.data(), width, height);
  smooth(image.crop(window.left, window.top, width, height), smoothed);
  const std::int32_t passes = passes_to_sharpness(at.linear);
  for (std::int32_t pass = 0; pass < passes; ++pass) smooth_again(smoothed, workspace);
  window.view = smoothed;
  return true;
}

/// Sums of grey values and of their squares over windows of `side` x `side` pixels, which move along a row of them.
class WindowSums {
 public:
  /// Takes a row of the area in, or out again.
  void add_row(const std::int16_t* row, std::int32_t wide, std::int32_t sign) {
    for (std::int32_t x = 0; x < wide; ++x) {
      const std::int32_t grey = row[x];
      sums_[static_cast<std::size_t>(x)] += sign * grey;
      squares_[static_cast<std::size_t>(x)] += sign * grey * grey;
    }
  }
  void begin() {
    sum = squares = 0;
    for (std::size_t x = 0; x < side; ++x) {
      sum += sums_[x];
      squares += squares_[x];
    }
  }
  void advance(std::int32_t from) {
    const auto out = static_cast<std::size_t>(from), in = out + side;
    sum += sums_[in] - sums_[out];
    squares += squares_[in] - squares_[out];
  }

  std::int32_t sum = 0, squares = 0;  ///< 13 x 13 squares of 11 bits fit

 private:
  std::array<std::int32_t, PlacePatchWorkspace::area_side + 1> sums_{}, squares_{};
};

/// Rows of the patch and of the area have the same length here, a power of two, so that one instruction takes many.
std::int64_t products_at(const std::int16_t* patch, const std::int16_t* area) {
  std::int64_t products = 0;
  for (std::int32_t v = 0; v < side; ++v) {
    const std::int16_t* const own = patch + std::ptrdiff_t{v} * padded_side;
    const std::int16_t* const row = area + std::ptrdiff_t{v} * PlacePatchWorkspace::area_stride;
    std::int32_t row_products = 0;
    for (std::int32_t u = 0; u < padded_side; ++u) row_products += own[u] * row[u];
    products += row_products;
  }
  return products;
}

/// The whole-pixel shift, in pixels of the patch, at which the area correlates best with the patch; false if the area
/// leaves the window.
bool best_shift(const NormalizedPatch& patch, const Window& window, const Prediction& at, std::int32_t radius_px,
                PlacePatchWorkspace& workspace, std::int32_t& best_x, std::int32_t& best_y) {
  const std::int32_t wide = side + 2 * radius_px;
  const auto local_x = at.x - static_cast<float>(window.left), local_y = at.y - static_cast<float>(window.top);
  if (!sample_patch(window.view, local_x, local_y, at.linear, wide, workspace.sampled.data())) return false;
  std::int16_t* const area = workspace.area.data();
  for (std::int32_t v = 0; v < wide; ++v) {
    const std::int32_t* const from = workspace.sampled.data() + std::ptrdiff_t{v} * wide;
    std::int16_t* const to = area + std::ptrdiff_t{v} * PlacePatchWorkspace::area_stride;
    // 12 bits, about zero.
    for (std::int32_t u = 0; u < wide; ++u) to[u] = static_cast<std::int16_t>((from[u] >> 8) - 2048);
  }
  std::array<std::int16_t, static_cast<std::size_t>(side) * padded_side> own{};
  for (std::int32_t v = 0; v < side; ++v) {
    std::copy_n(patch.data() + std::ptrdiff_t{v} * side, side, own.data() + std::ptrdiff_t{v} * padded_side);
  }
  WindowSums sums;
  for (std::int32_t v = 0; v + 1 < side; ++v)
    sums.add_row(area + std::ptrdiff_t{v} * PlacePatchWorkspace::area_stride, wide, 1);
  double best = 0;
  bool found = false;
  for (std::int32_t dy = 0; dy <= 2 * radius_px; ++dy) {
    const std::int16_t* const top = area + std::ptrdiff_t{dy} * PlacePatchWorkspace::area_stride;
    sums.add_row(top + std::ptrdiff_t{side - 1} * PlacePatchWorkspace::area_stride, wide, 1);
    sums.begin();
    for (std::int32_t dx = 0; dx <= 2 * radius_px; ++dx) {
      const double n = side * side, mean = sums.sum / n;
      const double variance = sums.squares - n * mean * mean;
      const std::int64_t products = products_at(own.data(), top + dx);
      sums.advance(dx);
      if (!(variance > n) || products <= 0) continue;
      const double score = static_cast<double>(products) * static_cast<double>(products) / variance;
      if (!(score > best)) continue;
      best = score;
      best_x = dx - radius_px;
      best_y = dy - radius_px;
      found = true;
    }
    sums.add_row(top, wide, -1);
  }
  return found;
}

bool find(const PlacePatch& patch, GrayView image, const Prediction& at, const PatchSearchParams& params,
          PlacePatchWorkspace& workspace, PatchSighting& sighting) {
  constexpr float least_contrast = 1;  // grey levels
  Window window;
  NormalizedPatch normalized;
  if (!prepare(patch, workspace)) return false;
  const SmoothView own(workspace.smoothed.data(), kept_patch_side, kept_patch_side);
  if (!extract_patch(own, inside(patch.x), inside(patch.y), {}, side, least_contrast, normalized)) return false;
  std::int32_t dx = 0, dy = 0;
  if (!cut_window(image, at, params.radius_px, workspace, window) ||
      !best_shift(normalized, window, at, params.radius_px, workspace, dx, dy)) {
    return false;
  }
  const auto x = static_cast<float>(dx), y = static_cast<float>(dy);
  const Linear2& l = at.linear;
  PatchWarp warp{at.x + l.xx * x + l.xy * y - static_cast<float>(window.left),
                 at.y + l.yx * x + l.yy * y - static_cast<float>(window.top), l, 0};
  const PatchWarp start = warp;
  // Over relief and at other scales the warp converges late: a second round finds three in four of those.
  const bool settled = register_patch(workspace.prepared, window.view, warp) ||
                       (warp.ncc >= params.min_score && register_patch(workspace.prepared, window.view, warp));
  if (!settled || !(warp.ncc >= params.min_score)) return false;
  const float moved = std::max(std::fabs(warp.x - start.x), std::fabs(warp.y - start.y));
  const float scale = std::max(1.0F, std::max(std::fabs(l.xx) + std::fabs(l.xy), std::fabs(l.yx) + std::fabs(l.yy)));
  if (!(moved <= max_patch_refinement_px * scale)) return false;
  sighting.x = warp.x + static_cast<float>(window.left);
  sighting.y = warp.y + static_cast<float>(window.top);
  sighting.score = warp.ncc;
  return true;
}

HarrisParams corner_params() {
  HarrisParams params;
  params.target_count = static_cast<std::int32_t>(limits::max_place_patches);
  params.min_distance_px = place_patch_side / 2;
  return params;
}

}  // namespace

Status begin_place_patches(GrayView image, HarrisWorkspace& harris, PlacePatchWorkspace& workspace,
                           PlacePatches& patches) {
  patches.clear();
  workspace.corners_found = false;
  return begin_corners(image, corner_params(), harris, workspace.corners);
}

Result<bool> place_patches_slice(GrayView image, HarrisWorkspace& harris, PlacePatchWorkspace& workspace,
                                 PlacePatches& patches) {
  if (!workspace.corners_found) {
    ILP_TAKE(const bool more, detect_corners_slice(image, corner_params(), harris, workspace.corners));
    workspace.corners_found = !more;
    return true;
  }
  for (const Corner& corner : workspace.corners) {
    PlacePatch patch;
    if (!cut(image, corner, patch) || !prepare(patch, workspace)) continue;
    if (!patches.push_back(patch)) break;
  }
  return false;
}

Status find_place_patches(std::span<const PlacePatch> patches, GrayView image,
                          const double (&plane_image_from_patches)[9], const PatchSearchParams& params,
                          PlacePatchWorkspace& workspace, PatchSightings& sightings) {
  sightings.clear();
  if (params.radius_px < 0 || params.radius_px > max_patch_search_px)
    return out_of_range(Argument::search_radius, params.radius_px);
  for (const double h : plane_image_from_patches) {
    if (!std::isfinite(h)) return out_of_range(Argument::homography, h);
  }
  std::array<std::uint16_t, limits::max_place_patches> in_view;
  std::size_t visible = 0;
  Prediction at;
  for (std::size_t i = 0; i < patches.size() && i < in_view.size(); ++i) {
    const PlacePatch& patch = patches[i];
    if (!std::isfinite(patch.x) || !std::isfinite(patch.y) || patch.brightest < patch.darkest) continue;
    if (!predict(plane_image_from_patches, patch, at)) continue;
    const bool inside_image = at.x >= 0 && at.y >= 0 && at.x <= static_cast<float>(image.width - 1) &&
                              at.y <= static_cast<float>(image.height - 1);
    if (inside_image) in_view[visible++] = static_cast<std::uint16_t>(i);
  }
  // Neighbours in the list stand near each other, so that every n-th one leaves the rest spread over the ground.
  const std::size_t sought = std::min(visible, limits::max_link_points);
  for (std::size_t i = 0; i < sought; ++i) {
    PatchSighting sighting;
    sighting.patch = in_view[i * visible / sought];
    if (!predict(plane_image_from_patches, patches[sighting.patch], at)) continue;
    if (find(patches[sighting.patch], image, at, params, workspace, sighting))
      static_cast<void>(sightings.push_back(sighting));
  }
  return {};
}

}  // namespace ilp
