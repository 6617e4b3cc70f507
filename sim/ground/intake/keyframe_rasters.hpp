// The products of a keyframe decoded, when they are looked at.
#pragma once

#include <array>
#include <string>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::ground {

/// Of hostile or damaged files; anything inside is representable as float and as a grid.
inline constexpr double largest_coordinate = 1e9;

struct DecodedProducts {
  KeyframeRasters rasters;
  std::array<std::string, 2> faults;  ///< by ProductKind; empty: decodes, or did not come
};

/// Rasters that the keyframe holds decoded are given back as they are. Never throws for what came down.
[[nodiscard]] DecodedProducts decode_products(const Keyframe& keyframe);

/// Takes the products with faults out of the keyframe, and notes the faults with their files.
void drop_faulty(Keyframe& keyframe, const std::array<std::string, 2>& faults, Outbox& outbox);

/// Inverse depth = offset + step * sample.
struct DepthScale {
  double offset = 0, step = 0;
};
[[nodiscard]] std::optional<DepthScale> depth_scale_of(const Metadata& metadata);

}  // namespace ilp::ground
