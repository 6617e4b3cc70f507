#include "fsw/products/bit_plan.hpp"

#include <algorithm>

namespace ilp {
namespace {

// JP2 boxes, main header and metadata.
constexpr double overhead_bytes = 1536;
// A thumbnail's bits per pixel of the whole image: enough to recognise the place.
constexpr double thumbnail_bpp = 0.06;
constexpr int thumbnail_layers = 2;
// An image cannot be placed on the ground without its depth map, so depth goes just before it.
constexpr double depth_lead = 1.0 / 1024;
// 8-bit samples need less without loss, noise included.
constexpr double lossless_bpp = 9;
constexpr double middle_index = 0.5;
constexpr double shares_of_the_link = 2;
// A link that carries less than this share of the way from the floors to the ceilings is narrow.
constexpr double narrow_link = 0.25;

/// Share of the way from the floors to the ceilings that the link allows, 0 to 1.
double rise(const MissionParameters& mission, std::size_t pixels, double budget_bytes) {
  if (!(budget_bytes > 0)) return 1;
  const double ordinary_pixels = (1 - mission.target_overlap) * static_cast<double>(pixels);
  const double floor = mission.image_bpp_floor + mission.depth_bpp_floor;
  const double span = mission.image_bpp_ceiling + mission.depth_bpp_ceiling - floor;
  const double granted = shares_of_the_link * budget_bytes - 2 * overhead_bytes;
  const double wanted = middle_index * span * ordinary_pixels / 8;
  const double left = granted - floor * ordinary_pixels / 8;
  if (!(left > 0)) return 0;
  return left < wanted ? left / wanted : 1;
}

}  // namespace

BitPlan plan_bits(const MissionParameters& mission, ProductKind kind, const PlannedKeyframe& keyframe) {
  BitPlan plan;
  if (keyframe.newly_seen == 0) return plan;
  plan.priority = keyframe.richness;
  plan.layers = mission.quality_layers;
  double floor = mission.image_bpp_floor;
  double ceiling = mission.image_bpp_ceiling;
  if (kind == ProductKind::depth) {
    floor = mission.depth_bpp_floor;
    ceiling = mission.depth_bpp_ceiling;
    plan.priority += depth_lead;
  }
  const auto area = static_cast<double>(keyframe.newly_seen);
  // A strip of new ground is never worth less than a thumbnail of the old, but no more than it takes without loss.
  const double least = std::min(thumbnail_bpp * static_cast<double>(keyframe.pixels), lossless_bpp * area);
  const double limited = rise(mission, keyframe.pixels, keyframe.budget_bytes);
  double bpp = floor + (ceiling - floor) * keyframe.richness * limited;
  if (kind == ProductKind::image) {
    const bool narrow = rise(mission, keyframe.pixels, keyframe.mean_budget_bytes) < narrow_link;
    const bool small = least >= lossless_bpp * area;
    const bool thumbnail = narrow && !small && keyframe.rank < mission.thumbnail_share;
    const bool lossless = !thumbnail && 1 - keyframe.rank < mission.lossless_share && limited >= 1;
    plan.region_only = small;
    if (thumbnail) plan.scheme = ProductScheme::thumbnail;
    if (thumbnail) plan.layers = std::min(plan.layers, thumbnail_layers);
    if (lossless) plan.scheme = ProductScheme::lossless_region;
    if (lossless) bpp = std::max(bpp, lossless_bpp);
  }
  double bits = bpp * area;
  if (kind == ProductKind::image && (plan.scheme == ProductScheme::thumbnail || bits < least)) bits = least;
  const double bytes = overhead_bytes + bits / 8;
  constexpr auto largest = static_cast<double>(limits::max_product_bytes);
  plan.grant_bytes = static_cast<std::uint32_t>(bytes < largest ? bytes : largest);
  return plan;
}

double link_budget_bytes(const MissionParameters& mission, double interval_s) {
  if (!(interval_s > 0)) return 0;
  const bool passes = mission.pass_period_s > 0;
  const double contact = passes ? mission.pass_length_s / mission.pass_period_s : 1;
  return mission.link_bytes_per_s * contact * interval_s;
}

}  // namespace ilp
