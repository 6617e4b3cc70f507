// Decodes the products of a keyframe when they are needed.
#pragma once

#include <array>
#include <string>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

/// Limits for hostile or damaged files: a value within them fits into a float and into a grid.
inline constexpr double largest_coordinate = 1e9;

struct DecodedProducts {
  KeyframeRasters rasters;
  std::array<std::string, 2> faults;  ///< by ProductKind; empty: decodes, or did not come
};

/// Rasters that the keyframe already holds decoded are returned unchanged. Never throws because of data that came down.
[[nodiscard]] DecodedProducts decode_products(const Keyframe& keyframe);

/// Takes the products with faults out of the keyframe, and notes the faults with their files.
void drop_faulty(Keyframe& keyframe, const std::array<std::string, 2>& faults, Outbox& outbox);

/// Inverse depth = offset + step * sample.
struct DepthScale {
  double offset = 0, step = 0;
};
[[nodiscard]] std::optional<DepthScale> depth_scale_of(const Metadata& metadata);

}  // namespace ilp::intake
