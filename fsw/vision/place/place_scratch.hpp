// Scratch of the functions that find and compare features of places. Nothing in it is kept from call to call.
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
  PlaceFeatures found[2];  ///< features of the two images whose overlap is measured
  PlaceMatch verified;
  PlacePatchWorkspace patches;
};

}  // namespace ilp
