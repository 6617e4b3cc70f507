#include "fsw/components/bit_plan.hpp"

namespace ilp {
namespace {

// JP2 boxes, main header and metadata.
constexpr double overhead_bytes = 1536;
// Of a thumbnail, for the whole image: enough to see where one is.
constexpr double thumbnail_bpp = 0.06;
// Without its depth map an image cannot be placed on the ground: depth goes just before it.
constexpr double depth_lead = 1.0 / 1024;

}  // namespace

BitPlan plan_bits(const MissionParameters& mission, ProductKind kind, double richness, std::uint32_t newly_seen,
                  std::size_t pixels) {
  BitPlan plan;
  plan.priority = richness;
  double floor = mission.image_bpp_floor;
  double ceiling = mission.image_bpp_ceiling;
  if (kind == ProductKind::depth) {
    floor = mission.depth_bpp_floor;
    ceiling = mission.depth_bpp_ceiling;
    plan.priority += depth_lead;
  }
  double bits = (floor + (ceiling - floor) * richness) * static_cast<double>(newly_seen);
  if (kind == ProductKind::image) {
    const bool thumbnail = newly_seen == 0 || richness < mission.thumbnail_below;
    const double least = thumbnail_bpp * static_cast<double>(pixels);
    if (thumbnail) plan.scheme = ProductScheme::thumbnail;
    // A strip of new ground is never worth less than a thumbnail of the old.
    if (thumbnail || bits < least) bits = least;
  }
  const double bytes = overhead_bytes + bits / 8;
  constexpr auto largest = static_cast<double>(limits::max_product_bytes);
  plan.grant_bytes = static_cast<std::uint32_t>(bytes < largest ? bytes : largest);
  return plan;
}

}  // namespace ilp
