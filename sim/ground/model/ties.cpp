#include "sim/ground/model/ties.hpp"

#include "fsw/places/strip_tie.hpp"

namespace ilp::model {
namespace {

/// More than units and distances of any two strips have between them; products of such numbers stay finite.
constexpr double largest_scale = 1e6, largest_translation = 1e12;

bool plausible(const TieRecord& tie) {
  const Similarity similarity = similarity_of(tie);
  return is_unit_quaternion(tie.q_to_from_this) && (similarity.translation.array().abs() < largest_translation).all() &&
         similarity.scale > 1 / largest_scale && similarity.scale < largest_scale;
}

bool levelled(const intake::Flight& flight, std::int64_t strip_id) {
  const auto strip = flight.strips.find(strip_id);
  return strip != flight.strips.end() && strip->second.frame.has_value();
}

}  // namespace

std::optional<Similarity> similarity_by_tie(const intake::Flight& flight, const TieRecord& tie) {
  if (levelled(flight, tie.id) || levelled(flight, tie.to_strip_id) || !plausible(tie)) return std::nullopt;
  return similarity_of(tie);
}

std::map<std::int64_t, TiedWorld> tied_worlds(const intake::Flight& flight) {
  std::map<std::int64_t, TiedWorld> worlds;
  for (const auto& [id, strip] : flight.strips) worlds[id] = {id, Similarity{}};
  // Ties are in the order of their strips and lead to earlier ones, so that the earlier world is known.
  for (const TieRecord& tie : flight.ties) {
    const auto earlier = worlds.find(tie.to_strip_id);
    const auto similarity = similarity_by_tie(flight, tie);
    if (!similarity || earlier == worlds.end() || tie.to_strip_id >= tie.id) continue;
    worlds[tie.id] = {earlier->second.strip_id, compose(earlier->second.world_from_strip, *similarity)};
  }
  return worlds;
}

}  // namespace ilp::model
