// The ties of the flight as similarities, where they hold on the ground.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::model {

/// earlier_from_strip. None where the record is no similarity, or one of the strips is levelled: ties are in the worlds
/// of the flight, and a levelled strip stands where the vehicle has measured it.
[[nodiscard]] std::optional<Similarity> similarity_by_tie(const intake::Flight& flight, const TieRecord& tie);

/// The world in which the strips that ties relate are compared: that of the earliest of them.
struct TiedWorld {
  std::int64_t strip_id = 0;
  Similarity world_from_strip;
};
/// By strip; each strip without a tie has its own.
[[nodiscard]] std::map<std::int64_t, TiedWorld> tied_worlds(const intake::Flight& flight);

}  // namespace ilp::model
