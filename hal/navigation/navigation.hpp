// Interface of a source of the vehicle's navigation samples: pose, velocity and height with standard deviations.
#pragma once

#include "fsw/base/navigation_sample.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

class NavigationSource {
 public:
  NavigationSource() = default;
  NavigationSource(const NavigationSource&) = delete;
  NavigationSource& operator=(const NavigationSource&) = delete;

  /// True for a recording, in which the samples of all times exist from the start. False if samples arrive as time
  /// passes.
  [[nodiscard]] virtual bool recorded() const = 0;
  /// Reads the next sample that was measured at or before `now`. Returns `not_ready` if there is none yet and
  /// `end_of_stream` if no more will come. Any other status reports a sample that was skipped; the next call continues
  /// after it. After a restart of the software a source may give the same samples again.
  virtual Status next(TimeNs now, NavigationSample& sample) = 0;

 protected:
  ~NavigationSource() = default;
};

}  // namespace ilp
