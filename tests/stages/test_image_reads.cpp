// How often the grey values of a keyframe are read from the store.

#include <gtest/gtest.h>

#include "tests/stages/recorded_flight.hpp"

namespace ilp::test {
namespace {

TEST(ImagesAtHand, TheGreyValuesOfAKeyframeAreReadTwiceAtMost) {
  const Recording& flight = recorded_flight(CameraKnown::yes);
  ASSERT_GE(flight.keyframe_frames.size(), 6U);
  int most = 0;
  for (const std::int64_t frame : flight.keyframe_frames) {
    const auto reads = flight.image_reads.find(frame);
    most = std::max(most, reads == flight.image_reads.end() ? 0 : reads->second);
  }
  RecordProperty("most_reads", most);
  EXPECT_LE(most, 2);
}

}  // namespace
}  // namespace ilp::test
