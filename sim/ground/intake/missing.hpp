// What has not come down, and where on the map it belongs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::ground {

struct Missing {
  std::int64_t keyframe_id = 0;
  std::string what;
  std::int64_t strip_id = 0;   ///< 0: not known
  std::optional<Vec3> centre;  ///< of the camera; between its neighbours' where its own is not known
};

/// By keyframe: those between the others of which nothing came, records, products that were made and did not come, and
/// layers of products that did. What never came may still be on its way, or have been given up on board.
[[nodiscard]] std::vector<Missing> missing_of(const Flight& flight);

}  // namespace ilp::ground
