// Keyframes of simulated worlds as verify_place sees them: the features of rendered images, with the true ground.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fsw/vision/place/place_features.hpp"
#include "sim/world/scenario.hpp"
#include "sim/world/visibility.hpp"

namespace ilp::test {

struct WorldView {
  std::string world;
  std::uint64_t seed = 0;    ///< of the world: another seed is another place
  bool further_sun = false;  ///< by 34 degrees
  PlaceFeatures features;
  world::TrueFrame truth;
};

/// Spots of one world that have nothing in common, and how often each is looked at under either sun.
struct WorldVisits {
  std::string world;
  std::uint64_t seed = 0;
  int spots = 1;
  int views = 1;
  int views_under_further_sun = 0;
  std::size_t features = limits::place_features;
};

/// A preset of the simulator, or one of these, in which every place looks like the next one:
///   dunes         sim/campaigns/revisit/dunes.ini
///   low-sun       the same dunes with hard shadows
///   long-dunes    longer and higher dunes, hardly any brightness of their own
///   ripples       low symmetric ripples, side by side
/// std::invalid_argument for other names.
[[nodiscard]] world::Scenario world_of_places(const std::string& name);

/// Renders 640 x 480 px as a flight does. The cameras look down within 5 degrees, with any heading, from heights whose
/// ratios are 0.7 to 1.4, up to a sixth of an image beside the middle of the spot.
void add_views(const WorldVisits& visits, std::vector<WorldView>& views);

/// Of a pair: the smaller of the shares of their ground that the other one sees. 0 for other worlds.
[[nodiscard]] double common_ground(const WorldView& a, const WorldView& b);
/// Neither sees anything of the other's ground. Views of the same seed in other worlds may share their brightness.
[[nodiscard]] bool nothing_in_common(const WorldView& a, const WorldView& b);

}  // namespace ilp::test
