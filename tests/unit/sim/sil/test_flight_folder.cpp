#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "sim/sil/flight_folder.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::sil {
namespace {

namespace fs = std::filesystem;

void leave(const fs::path& file) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << "something";
}

std::string refusal(const fs::path& out, bool resume) {
  return test::error_of([&] { prepare_folder(out, resume); });
}

class FlightFolder : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
  fs::path out_ = folder_ / "out";
};

TEST_F(FlightFolder, AStartThatNeverFlewBlocksNoOtherStart) {
  prepare_folder(out_, false);
  leave(out_ / "flight" / "images" / "0001.pgm");
  leave(out_ / "frames.txt");
  leave(out_ / "flight.db-wal");
  leave(out_ / "flight.db");
  EXPECT_TRUE(test::says(refusal(out_, true), "without --resume")) << refusal(out_, true);
  prepare_folder(out_, false);
  EXPECT_FALSE(fs::exists(out_ / "flight.db"));
  EXPECT_FALSE(fs::exists(out_ / "flight"));
  EXPECT_TRUE(fs::is_directory(out_ / "outbox"));
}

TEST_F(FlightFolder, AFlightThatHasBegunIsNeverOverwritten) {
  prepare_folder(out_, false);
  leave(out_ / "flight.db");
  flight_has_begun(out_);
  EXPECT_TRUE(test::says(refusal(out_, false), "not empty")) << refusal(out_, false);
  EXPECT_TRUE(fs::exists(out_ / "flight.db"));
  EXPECT_EQ(refusal(out_, true), "");
}

TEST_F(FlightFolder, WhatTheUserPutBesideAnUnfinishedStartIsKept) {
  prepare_folder(out_, false);
  leave(out_ / "thesis.txt");
  EXPECT_TRUE(test::says(refusal(out_, false), "not empty"));
  EXPECT_TRUE(fs::exists(out_ / "thesis.txt"));
}

TEST_F(FlightFolder, ImagesThatWereNotRenderedToTheEndBlockNothingAndNeverCostAFlight) {
  leave(out_ / "flight.db");  // of recorded images: the folder has no images
  prepare_render_folder(out_);
  leave(out_ / "flight" / "images" / "0001.pgm");
  prepare_render_folder(out_);
  EXPECT_FALSE(fs::exists(out_ / "flight" / "images"));
  EXPECT_TRUE(fs::exists(out_ / "flight.db"));
  leave(out_ / "flight" / "images" / "0001.pgm");
  images_are_complete(out_);
  EXPECT_THROW(prepare_render_folder(out_), std::runtime_error);
  EXPECT_TRUE(fs::exists(out_ / "flight" / "images"));
}

}  // namespace
}  // namespace ilp::sil
