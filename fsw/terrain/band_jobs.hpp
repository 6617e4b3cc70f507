// The bands of a pair as jobs of a compute device (docs/compute.md).
#pragma once

#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "hal/compute/compute.hpp"

namespace ilp {

/// The jobs of stereo bands. `workspace` is the processor's.
[[nodiscard]] ComputeForm stereo_band_form(StereoBandWorkspace& workspace);

/// Carries nothing from one pair to the next, and nothing of it is on record: after a restart the pair begins again.
class BandJobs {
 public:
  void use(Compute& compute, StereoBandWorkspace& workspace) {
    compute_ = &compute;
    workspace_ = &workspace;
  }
  /// A pair begins: a device matches its bands if there is one.
  void begin(StereoWorkspace& memory, StereoBandJob& job, StereoMatcher& matcher);
  /// Gets the band that the matcher wants; whether it has it.
  Result<bool> get(StereoMatcher& matcher, StereoBandJob& job);
  /// A device does the job.
  [[nodiscard]] bool waits() const { return progress_ == ComputeProgress::waiting; }

 private:
  [[nodiscard]] bool submitted() const { return progress_ == ComputeProgress::working || waits(); }

  Compute* compute_ = nullptr;
  StereoBandWorkspace* workspace_ = nullptr;
  ComputeProgress progress_ = ComputeProgress::none;  ///< of the last job
};

}  // namespace ilp
