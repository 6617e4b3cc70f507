// Links and ties that hold anything, read as they come down and joined into one model.
#include <algorithm>
#include <cmath>

#include "sim/ground/intake/record_file.hpp"
#include "sim/ground/model/joined_model.hpp"
#include "tests/fuzz/ground/known_outbox.hpp"
#include "tests/unit/ground/model/noisy_flight.hpp"

namespace ilp::fuzz {
namespace {

struct KnownFlight : model::test::NoisyFlight {
  KnownFlight() {
    using model::test::looking_down;
    fly_two_lanes(3);
    fly(3, {looking_down(2.5, -2, 1)}, second_);
    link(3, 4);
    link(2, 5);
    link(2, 7);
    // A joined model costs time with every point.
    for (auto& [id, keyframe] : flight_.keyframes) {
      std::vector<intake::StructureTrackPoint>& points = keyframe.points;
      points.resize(std::min<std::size_t>(points.size(), 60));
    }
  }

  [[nodiscard]] KnownFile file() const {
    std::vector<intake::RecordEntry> entries;
    for (const LinkRecord& link : flight_.links) {
      const std::vector<LinkPoint>& points = flight_.link_points.at(link.id);
      const auto* const bytes = reinterpret_cast<const std::uint8_t*>(points.data());
      LinkRecord record = link;
      record.points.bytes = static_cast<std::uint32_t>(points.size() * sizeof(LinkPoint));
      entries.push_back(intake::entry_of(record, {std::vector<std::uint8_t>(bytes, bytes + record.points.bytes)}));
    }
    for (const std::int64_t strip : {2, 3}) {
      TieRecord tie{.id = strip, .to_strip_id = strip - 1};
      entries.push_back(intake::entry_of(tie));
    }
    return {"records-000007.ilp", intake::write_record_file(entries)};
  }
  [[nodiscard]] const intake::Flight& flight() const { return flight_; }
};

}  // namespace

void ground_links(Octets input) {
  static const KnownFlight known;
  static const KnownFile valid = known.file();
  Choices choices(input);
  KnownFile file = valid;
  change(choices, file);
  intake::OutboxBuilder builder;
  builder.add(file.name, file.bytes);
  intake::Outbox outbox = builder.finish();
  intake::Flight sent = intake::index_flight(outbox);
  intake::Flight flight = known.flight();
  require(input.size() > 1 || sent.links.size() == flight.links.size(), "links of a flight are left out");
  flight.links = std::move(sent.links);
  flight.link_points = std::move(sent.link_points);
  flight.ties = std::move(sent.ties);
  const model::JoinedFlight joined = model::join_strips(flight, [](const std::string&) {});
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (!keyframe.posed()) continue;
    for (const double c : keyframe.pose->centre) require(std::isfinite(c), "a pose that is none");
    require(std::isfinite(keyframe.depth_scale) && keyframe.depth_scale > 0, "depths in no unit");
  }
  for (const model::JoinedModel& model : joined.models) {
    require(model.members.size() >= 2, "a model of one keyframe");
    require(std::isfinite(model.median_error_px), "a model without errors");
  }
}

}  // namespace ilp::fuzz
