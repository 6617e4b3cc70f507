// Converts the flight's ties to similarities between the ground's worlds of strips.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::model {

/// The similarity earlier_from_strip of a tie. None if the record's values are implausible, or if one of the strips is
/// levelled (level_strips.hpp): ties relate the onboard worlds, and levelling has changed the strip's world.
[[nodiscard]] std::optional<Similarity> similarity_by_tie(const intake::Flight& flight, const TieRecord& tie);

/// The world that a strip shares with others by ties: that of the earliest strip of them.
struct TiedWorld {
  std::int64_t strip_id = 0;
  Similarity world_from_strip;
};
/// Key: strip id. A strip without a tie to an earlier one has its own world.
[[nodiscard]] std::map<std::int64_t, TiedWorld> tied_worlds(const intake::Flight& flight);

}  // namespace ilp::model
