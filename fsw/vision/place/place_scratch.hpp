// Scratch of everything that finds and compares features of places; it carries nothing from call to call.
#pragma once

#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/place/place_feature_workspace.hpp"
#include "fsw/vision/place/place_match_workspace.hpp"
#include "fsw/vision/place/place_patches.hpp"

namespace ilp {

struct PlaceScratch {
  HarrisWorkspace harris;
  PlaceFeatureWorkspace features;
  PlaceMatchWorkspace match;
  PlaceFeatures found[2];  ///< of the two images whose overlap is measured
  PlaceMatch verified;
  PlacePatchWorkspace patches;
};

}  // namespace ilp
