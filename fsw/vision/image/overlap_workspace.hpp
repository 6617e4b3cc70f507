// Scratch of measure_overlap; a component owns one.
#pragma once

#include "fsw/vision/image/coarse_search.hpp"
#include "fsw/vision/image/overlap.hpp"
#include "fsw/vision/image/pyramid.hpp"
#include "fsw/vision/image/registration.hpp"

namespace ilp {

struct OverlapWorkspace {
  Pyramid a, b;
  CoarseWorkspace coarse;
  CoarseCandidates candidates;
  RegistrationTemplate registration;
};

}  // namespace ilp
