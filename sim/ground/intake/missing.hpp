// Lists data that has not come down, with its position on the map.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

struct Missing {
  std::int64_t keyframe_id = 0;
  std::string what;            ///< in words
  std::int64_t strip_id = 0;   ///< 0: unknown
  std::optional<Vec3> centre;  ///< camera centre; interpolated between neighbours in the strip if it is unknown
};

/// Lists, in the order of keyframe ids: keyframes of which nothing came although later ones did, missing records,
/// products that were made and did not come, and missing layers of products. Missing data may still be on its way, or
/// may have been dropped on board.
[[nodiscard]] std::vector<Missing> missing_of(const Flight& flight);

}  // namespace ilp::intake
