#include "sim/ground/intake/missing.hpp"

#include <algorithm>

namespace ilp::intake {
namespace {

std::optional<Vec3> centre_of(const Keyframe& keyframe) {
  if (!keyframe.posed()) return std::nullopt;
  return Vec3(keyframe.pose->centre[0], keyframe.pose->centre[1], keyframe.pose->centre[2]);
}

/// The nearest posed keyframes before and after, if they are of one strip.
void place_between_neighbours(const Flight& flight, Missing& missing) {
  const auto after_id = flight.keyframes.upper_bound(missing.keyframe_id);
  auto before = std::make_reverse_iterator(flight.keyframes.lower_bound(missing.keyframe_id));
  auto after = after_id;
  while (before != flight.keyframes.rend() && !before->second.posed()) ++before;
  while (after != flight.keyframes.end() && !after->second.posed()) ++after;
  if (before == flight.keyframes.rend() || after == flight.keyframes.end()) return;
  const Keyframe &a = before->second, &b = after->second;
  if (a.strip_id != b.strip_id) return;
  const double share = static_cast<double>(missing.keyframe_id - a.id) / static_cast<double>(b.id - a.id);
  missing.strip_id = a.strip_id;
  missing.centre = *centre_of(a) + share * (*centre_of(b) - *centre_of(a));
}

std::vector<std::string> lacks_of(const Keyframe& keyframe) {
  std::vector<std::string> lacks;
  if (!keyframe.record) lacks.emplace_back("its records");
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    const auto& record = keyframe.product_records[static_cast<std::size_t>(kind)];
    const auto& product = keyframe.product(kind);
    const std::string name = std::string("its ") + name_of(kind);
    // Where all ground is known already, the record says that no file was made.
    if (record && record->bytes != 0 && !product) lacks.push_back(name);
    if (record && product && product->layers < record->layers) {
      lacks.push_back("layers " + std::to_string(product->layers + 1) + " to " + std::to_string(record->layers) +
                      " of " + name);
    }
  }
  return lacks;
}

}  // namespace

std::vector<Missing> missing_of(const Flight& flight) {
  std::vector<Missing> all;
  if (flight.keyframes.empty()) return all;
  // A damaged record may name any keyframe: a gap of more than a flight's worth is none.
  constexpr std::int64_t longest_gap = 10000;
  constexpr std::size_t longest_list = 100000;
  std::int64_t expected = std::min<std::int64_t>(1, flight.keyframes.begin()->first);
  for (const auto& [id, keyframe] : flight.keyframes) {
    for (; expected < id && id - expected <= longest_gap && all.size() < longest_list; ++expected) {
      Missing& missing = all.emplace_back(Missing{expected, "everything", 0, std::nullopt});
      place_between_neighbours(flight, missing);
    }
    expected = id + 1;
    for (std::string& lack : lacks_of(keyframe)) {
      Missing& missing = all.emplace_back(Missing{id, std::move(lack), keyframe.strip_id, centre_of(keyframe)});
      if (!missing.centre) place_between_neighbours(flight, missing);
    }
  }
  return all;
}

}  // namespace ilp::intake
