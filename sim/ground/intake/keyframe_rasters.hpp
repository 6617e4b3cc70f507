// Decodes the products of a keyframe on demand.
#pragma once

#include <array>
#include <string>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

/// Largest plausible magnitude of a coordinate from a file, which may be damaged or hostile: larger values might not
/// fit into a float or a grid.
inline constexpr double largest_coordinate = 1e9;

struct DecodedProducts {
  KeyframeRasters rasters;
  std::array<std::string, 2> faults;  ///< index: ProductKind; empty: decoded, or not received
};

/// Decodes the products of the keyframe. Rasters that it holds decoded already are returned unchanged. Bad data gives a
/// fault, not an exception.
[[nodiscard]] DecodedProducts decode_products(const Keyframe& keyframe);

/// Removes the products with faults from the keyframe, and sets the faults of their files in `outbox`. `faults`: as in
/// DecodedProducts.
void drop_faulty(Keyframe& keyframe, const std::array<std::string, 2>& faults, Outbox& outbox);

/// Inverse depth = offset + step * sample.
struct DepthScale {
  double offset = 0, step = 0;
};
/// From the metadata of a depth product; none if it does not state a valid scale.
[[nodiscard]] std::optional<DepthScale> depth_scale_of(const Metadata& metadata);

}  // namespace ilp::intake
