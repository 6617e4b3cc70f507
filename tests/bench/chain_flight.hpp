// A flight in memory whose processor time is charged to what it was spent on.
#pragma once

#include <string>
#include <vector>

#include "sim/world/scenario.hpp"

namespace ilp::bench {

/// Calls a reference for comparison, and says which processor time each call took, in ms.
class Reference {
 public:
  virtual ~Reference() = default;
  virtual double run() = 0;
};

struct PartTime {
  std::string name;
  double ms = 0;  ///< per keyframe
};

struct ChainTimes {
  int frames = 0, keyframes = 0;
  double all_ms = 0;        ///< per keyframe
  double reference_ms = 0;  ///< median of one reference call per keyframe, between the minor frames
  std::vector<PartTime> parts;

  [[nodiscard]] double of(const std::string& name) const;
};

/// Thread's processor time, ms.
[[nodiscard]] double processor_ms();
[[nodiscard]] double median(std::vector<double> values);

/// Flies frames of the default scenario with a store and a link in memory. Parts are the components by their names in
/// the schedule, the parts of the work of the dense matcher ("dense_matcher/idle", "/resample", "/match", "/depth",
/// "/errors",
/// "/mask", "/record") and "executive", which is what remains.
/// `settings` change the scenario.
[[nodiscard]] ChainTimes fly_chain(int frames, Reference& reference, std::vector<world::ScenarioEntry> settings = {});

}  // namespace ilp::bench
