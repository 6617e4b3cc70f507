// Scratch of corner detection and matching, megabytes. It carries nothing from step to step, so that components share
// one.
#pragma once

#include "fsw/vision/features/harris.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"

namespace ilp {

struct FeatureScratch {
  HarrisWorkspace harris;
  MatcherWorkspace matcher;
};

}  // namespace ilp
