// Links and ties that form cycles, contradict each other or hold anything: what no flight makes is left out by name,
// and the rest is joined into models that are valid.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <set>

#include "sim/ground/intake/record_file.hpp"
#include "tests/unit/ground/model/noisy_flight.hpp"

namespace ilp::model {
namespace {

using test::looking_down, test::NoisyFlight;

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();

/// Links and ties as they come down, with the keyframes that they name.
class SentLinks : public NoisyFlight {
 public:
  SentLinks() {
    fly_two_lanes(4);
    link(1, 8);
    link(4, 5);
  }
  [[nodiscard]] LinkRecord valid(std::int64_t place, std::int64_t newer, std::int64_t number) {
    link(place, newer);
    LinkRecord record = flight_.links.back();
    points_of_[link_id(newer, number)] = flight_.link_points[record.id];
    flight_.links.pop_back();
    record.id = link_id(newer, number);
    return record;
  }
  void send(const LinkRecord& link, std::vector<std::uint8_t> points = {}) {
    LinkRecord record = link;
    record.points.bytes = static_cast<std::uint32_t>(points.size());
    entries_.push_back(intake::entry_of(record, {std::move(points)}));
  }
  void send(const TieRecord& tie) { entries_.push_back(intake::entry_of(tie)); }
  [[nodiscard]] intake::Flight read() {
    for (const auto& [id, keyframe] : flight_.keyframes) {
      KeyframeRecord record{.id = id, .strip_id = keyframe.strip_id};
      entries_.push_back(intake::entry_of(record));
    }
    intake::OutboxBuilder builder;
    builder.add("records-000008.ilp", intake::write_record_file(entries_));
    intake::Outbox outbox = builder.finish();
    EXPECT_EQ(outbox.files[0].fault, "");
    return intake::index_flight(outbox);
  }

 private:
  std::vector<intake::RecordEntry> entries_;
  std::map<std::int64_t, std::vector<LinkPoint>> points_of_;
};

std::string remark_about(const intake::Flight& flight, const std::string& what) {
  for (const std::string& remark : flight.remarks) {
    if (remark.starts_with(what + " is left out: ")) return remark.substr(what.size() + 14);
  }
  return "";
}

TEST(HostileLinks, WhatNoFlightMakesIsLeftOutByName) {
  SentLinks flight;
  const auto changed = [&](std::int64_t number, auto change) {
    LinkRecord record = flight.valid(2, 7, number);
    change(record);
    flight.send(record);
    return "link " + std::to_string(record.id);
  };
  const std::string good = changed(0, [](LinkRecord&) {});
  std::map<std::string, std::string> wanted;
  const std::string backwards = "it does not lead to an earlier keyframe";
  wanted[changed(1, [](LinkRecord& link) { link.place_id = 7; })] = backwards;  // itself
  wanted[changed(2, [](LinkRecord& link) { link.place_id = 8; })] = backwards;  // a cycle with 8 -> 7
  wanted[changed(3, [](LinkRecord& link) { link.place_id = 0; })] = backwards;
  wanted[changed(4, [](LinkRecord& link) { link.place_strip_id = 3; })] = backwards;
  wanted[changed(5, [](LinkRecord& link) { link.strip_id = 5; })] = "its keyframes are in other strips";
  wanted[changed(6, [](LinkRecord& link) { link.place_strip_id = 2; })] = "its keyframes are in other strips";
  wanted[changed(7, [](LinkRecord& link) { link.keyframe_id = 8; })] = "its number is not one of keyframe 8";
  wanted[changed(8, [](LinkRecord& link) { link.id = 3; })] = "its number is not one of keyframe 7";
  wanted[changed(9, [](LinkRecord& link) { link.verdict = static_cast<LinkVerdict>(99); })] = "its verdict is unknown";
  wanted[changed(10, [](LinkRecord& link) { link.rms_px = nan; })] = "one of its values is no number";
  wanted[changed(11, [](LinkRecord& link) { link.keyframe_from_place_px[8] = infinite; })] =
      "one of its values is no number";
  wanted[changed(12, [](LinkRecord& link) { link.covariance[27] = -infinite; })] = "one of its values is no number";
  const LinkRecord many = flight.valid(2, 7, 13);
  flight.send(many, std::vector<std::uint8_t>(8 * (limits::max_link_points + 1)));
  wanted["link " + std::to_string(many.id)] = "no link has 129 points";
  const LinkRecord uneven = flight.valid(2, 7, 14);
  flight.send(uneven, std::vector<std::uint8_t>(12));
  wanted["link " + std::to_string(uneven.id)] = "no link has 1 point";
  for (const std::int64_t to : {2, 3, 0}) {
    TieRecord tie{.id = 2, .to_strip_id = to};
    SentLinks of_tie;
    of_tie.send(tie);
    const intake::Flight read = of_tie.read();
    EXPECT_EQ(remark_about(read, "tie 2"), "it does not lead to an earlier strip") << to;
    EXPECT_TRUE(read.ties.empty());
  }
  const intake::Flight read = flight.read();
  for (const auto& [link, why] : wanted) EXPECT_EQ(remark_about(read, link), why) << link;
  ASSERT_EQ(read.links.size(), 1U);
  EXPECT_EQ("link " + std::to_string(read.links[0].id), good);
  EXPECT_EQ(read.link_points.size(), 1U);
}

TEST(HostileLinks, ThousandsAreBoundedAndCounted) {
  SentLinks flight;
  const LinkRecord valid = flight.valid(2, 7, 0);
  for (std::int64_t id = 1; id <= 5000; ++id) {
    LinkRecord record = valid;
    record.id = id;
    flight.send(record);
    TieRecord tie{.id = id, .to_strip_id = id + 1};
    flight.send(tie);
  }
  const intake::Flight read = flight.read();
  EXPECT_EQ(read.links.size(), static_cast<std::size_t>(limits::max_links_per_keyframe));
  EXPECT_TRUE(read.ties.empty());
  EXPECT_EQ(read.remarks.size(), 42U);
  EXPECT_NE(std::find(read.remarks.begin(), read.remarks.end(), "4964 further links left out"), read.remarks.end());
  EXPECT_NE(std::find(read.remarks.begin(), read.remarks.end(), "4980 further ties left out"), read.remarks.end());
}

/// What join_strips promises, whatever the links say.
void expect_valid(const intake::Flight& flight, const JoinedFlight& joined) {
  std::set<std::int64_t> members;
  for (const JoinedModel& model : joined.models) {
    EXPECT_GE(model.members.size(), 2U);
    EXPECT_TRUE(std::isfinite(model.median_error_px));
    for (const JoinedModel::Member& member : model.members) {
      EXPECT_TRUE(members.insert(member.keyframe_id).second)
          << "keyframe " << member.keyframe_id << " is in two models";
      EXPECT_TRUE(member.before.allFinite() && member.after.allFinite());
    }
  }
  std::size_t in_strips = 0;
  for (const auto& [id, strip] : flight.strips) in_strips += strip.keyframes.size();
  EXPECT_EQ(in_strips, flight.keyframes.size());
  for (const auto& [id, keyframe] : flight.keyframes) {
    ASSERT_TRUE(keyframe.pose);
    for (const double c : keyframe.pose->centre) EXPECT_TRUE(std::isfinite(c)) << id;
    EXPECT_TRUE(std::isfinite(keyframe.depth_scale) && keyframe.depth_scale > 0) << id;
    for (const StripApart& strip : joined.apart) EXPECT_FALSE(strip.why.empty());
  }
}

/// Anything that a record can hold and that passes as a link or tie of a flight, and much that does not.
class Liar {
 public:
  explicit Liar(unsigned seed) : random_(seed) {}
  std::int64_t below(std::int64_t end) { return static_cast<std::int64_t>(random_()) % end; }
  double value() {
    static constexpr double special[] = {0,   -0.0, 1,    -1,  1e-300, 1e300,    -1e300,    5e-324,
                                         1e9, -1e9, 1e-9, 640, nan,    infinite, -infinite, 0.5};
    return special[below(std::size(special))];
  }
  void lie(LinkRecord& link, std::vector<LinkPoint>& points, std::int64_t keyframes) {
    if (below(3) == 0) link.place_id = below(keyframes + 2);
    if (below(3) == 0) link.keyframe_id = below(keyframes + 2);
    if (below(3) == 0) link.strip_id = below(4);
    if (below(3) == 0) link.place_strip_id = below(4);
    if (below(2) == 0) link.keyframe_from_place_px[below(9)] = value();
    if (below(3) == 0) link.closing_error = value();
    if (below(3) == 0) link.scale = value();
    if (below(3) == 0) link.translation[below(3)] = value();
    for (LinkPoint& point : points) {
      if (below(3) == 0) point.x = static_cast<std::uint16_t>(random_());
      if (below(3) == 0) point.place_y = static_cast<std::uint16_t>(random_());
    }
  }
  TieRecord tie() {
    TieRecord tie{.id = below(4), .to_strip_id = below(4)};
    tie.q_to_from_this[0] = below(4) == 0 ? value() : 1;
    if (below(2) == 0) tie.scale = value();
    if (below(2) == 0) tie.translation[below(3)] = value();
    return tie;
  }

 private:
  std::mt19937 random_;
};

class LyingFlight : public NoisyFlight {
 public:
  explicit LyingFlight(unsigned seed) {
    fly_two_lanes(3);
    fly(3, {looking_down(2.5, -2, 1), looking_down(5, -2, 1)}, second_);
    for (auto& [id, keyframe] : flight_.keyframes) {
      keyframe.points.resize(std::min<std::size_t>(keyframe.points.size(), 40));
    }
    Liar liar(seed);
    for (int i = 0; i < 12; ++i) {
      // In either direction, so that links form cycles.
      const std::int64_t a = 1 + liar.below(8), b = 1 + liar.below(8);
      if (a == b) continue;
      link(a, b);
      if (liar.below(4) != 0) liar.lie(flight_.links.back(), flight_.link_points[flight_.links.back().id], 8);
    }
    for (int i = 0; i < 4; ++i) flight_.ties.push_back(liar.tie());
    std::sort(flight_.ties.begin(), flight_.ties.end(),
              [](const TieRecord& a, const TieRecord& b) { return a.id < b.id; });
    const JoinedFlight joined = join();
    expect_valid(flight_, joined);
  }
};

TEST(HostileLinks, OfAnyKindAreJoinedIntoSoundModelsOrNone) {
  const char* const more = std::getenv("ILP_HOSTILE_FLIGHTS");
  const unsigned flights = more == nullptr ? 60 : static_cast<unsigned>(std::stoul(more));
  // In 598 and 624 an adjustment leads to what is no place.
  std::vector<unsigned> seeds{598, 624};
  for (unsigned seed = 1; seed <= flights; ++seed) seeds.push_back(seed);
  for (const unsigned seed : seeds) {
    SCOPED_TRACE(seed);
    const LyingFlight flight(seed);
    if (HasFailure()) return;
  }
}

/// Rings of links, each point of which is somewhere else for each link: 16 links from every keyframe.
class Contradictions : public NoisyFlight {
 public:
  Contradictions() {
    fly_two_lanes(8);
    std::mt19937 random(5);
    for (std::int64_t newer = 2; newer <= 16; ++newer) {
      for (std::int64_t number = 0; number < limits::max_links_per_keyframe; ++number) {
        LinkRecord record;
        record.id = link_id(newer, number);
        record.keyframe_id = newer;
        record.place_id = 1 + static_cast<std::int64_t>(random()) % (newer - 1);
        record.strip_id = flight_.keyframes[newer].strip_id;
        record.place_strip_id = flight_.keyframes[record.place_id].strip_id;
        for (int i = 0; i < 9; i += 4) record.keyframe_from_place_px[i] = 1;
        std::vector<LinkPoint>& points = flight_.link_points[record.id];
        for (std::size_t i = 0; i < limits::max_link_points; ++i) {
          const auto any = [&](unsigned side) { return static_cast<std::uint16_t>(random() % (32 * side)); };
          points.push_back({any(640), any(480), any(640), any(480)});
        }
        flight_.links.push_back(record);
      }
    }
    const JoinedFlight joined = join();
    expect_valid(flight_, joined);
    // No strip moved by more than what its own true points allow.
    EXPECT_LT(position_error(Similarity{}, {1, 2, 3, 4, 5, 6, 7, 8}), 0.05);
  }
};

TEST(HostileLinks, ThirtyThousandPointsThatContradictEachOtherMoveNoStripAway) {
  const Contradictions flight;
}

}  // namespace
}  // namespace ilp::model
