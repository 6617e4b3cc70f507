// A source of the vehicle's navigation samples.
#pragma once

#include "fsw/base/navigation_sample.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

class NavigationSource {
 public:
  NavigationSource() = default;
  NavigationSource(const NavigationSource&) = delete;
  NavigationSource& operator=(const NavigationSource&) = delete;

  /// A recording has the samples of any time at once. Otherwise they arrive as time passes.
  [[nodiscard]] virtual bool recorded() const = 0;
  /// The next sample measured at or before `now`. `not_ready` when there is none yet, `end_of_stream` when there will
  /// be no more. Any other status reports a sample that was left out, and the next call goes on after it. After a
  /// restart of the software a source may give the same samples again.
  virtual Status next(TimeNs now, NavigationSample& sample) = 0;

 protected:
  ~NavigationSource() = default;
};

}  // namespace ilp
