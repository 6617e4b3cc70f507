// The flight in several processes makes the same records and products as in one, whatever happens to the processes.
#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <thread>

#include "tests/distributed/spread_flight.hpp"
#include "tests/integration/flight_files.hpp"

namespace ilp {
namespace {

using test::SpreadFlight;
using Split = std::vector<std::string>;

const Split two = {"head,overlap_checker,camera_calibrator,structure_and_motion,storage_manager,compressor",
                   "dense_matcher,place_memory,richness_scorer"};
const Split three = {"head,storage_manager", "overlap_checker,camera_calibrator,structure_and_motion",
                     "dense_matcher,richness_scorer,compressor,place_memory"};
const Split each = {"head",         "overlap_checker", "camera_calibrator", "structure_and_motion", "dense_matcher",
                    "place_memory", "richness_scorer", "compressor",        "storage_manager"};

void sleep_ms(int milliseconds) {
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

void expect_same_flight(const Split& split) {
  SpreadFlight flight(split);
  flight.start_all();
  EXPECT_EQ(flight.wait(), std::vector<int>(split.size(), 0)) << flight.output(0);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
  EXPECT_NE(flight.output(0).find("heap requests after sealing: 0\n"), std::string::npos) << flight.output(0);
}

TEST(SpreadFlight, TwoProcessesMakeTheSame) {
  expect_same_flight(two);
}

TEST(SpreadFlight, ThreeProcessesMakeTheSame) {
  expect_same_flight(three);
}

TEST(SpreadFlight, AProcessForEachStageMakesTheSame) {
  expect_same_flight(each);
}

/// Disturbs the flight until it has ended, and compares.
template <typename Disturb>
void expect_same_in_spite_of(const Split& split, std::uint64_t seed, Disturb disturb) {
  std::mt19937_64 random(seed);
  SpreadFlight flight(split);
  flight.start_all();
  int disturbances = 0;
  for (int waited = 0; !flight.keep_up(); waited += 100) {
    ASSERT_LT(waited, 120'000) << "no end; the head says: " << flight.output(0);
    sleep_ms(50 + static_cast<int>(random() % 100));
    if (disturbances < 12) {
      disturb(flight, random);
      ++disturbances;
    }
  }
  EXPECT_GT(disturbances, 3);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
}

TEST(SpreadFlight, KilledAgainAndAgainTheProcessesMakeTheSame) {
  for (const std::uint64_t seed : {1U, 2U}) {
    expect_same_in_spite_of(three, seed, [](SpreadFlight& flight, std::mt19937_64& random) {
      const std::size_t process = random() % three.size();
      if (flight.runs(process)) flight.kill(process);
    });
  }
}

TEST(SpreadFlight, AProcessThatHangsForAWhileLosesNothing) {
  expect_same_in_spite_of(three, 3, [](SpreadFlight& flight, std::mt19937_64& random) {
    const std::size_t process = random() % three.size();
    if (!flight.runs(process)) return;
    flight.freeze(process);
    sleep_ms(300);
    flight.thaw(process);
  });
}

TEST(SpreadFlight, AStageRunsInOneProcess) {
  SpreadFlight flight(two);
  flight.start(0);
  flight.start(1);
  for (int k = 0; k < 200 && flight.output(1).find("running ") == std::string::npos; ++k) sleep_ms(50);
  for (const std::string taken : {"dense_matcher", "compressor,dense_matcher", "compressor"}) {
    const test::ProgramResult second = test::run_program(flight.node_command(taken));
    EXPECT_EQ(second.exit_status, 1) << second.output;
    EXPECT_NE(second.output.find("is run by another process"), std::string::npos) << second.output;
  }
  EXPECT_EQ(flight.wait(), (std::vector<int>{0, 0})) << flight.output(0);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
}

TEST(SpreadFlight, AProcessWithAnotherMissionIsRefused) {
  SpreadFlight flight(two);
  flight.start(0);
  const auto mission = flight.folder() / "other.ini";
  test::write_file(mission, "[overlap]\ntarget_overlap = 0.85\n");
  const test::ProgramResult other = test::run_program(flight.node_command(two[1], {"--mission", mission.string()}));
  EXPECT_EQ(other.exit_status, 1) << other.output;
  EXPECT_NE(other.output.find("differs from the flight that it joins"), std::string::npos) << other.output;
  flight.start(1);
  EXPECT_EQ(flight.wait(), (std::vector<int>{0, 0})) << flight.output(0);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
}

TEST(SpreadFlight, WhatCannotRunByItselfIsSaid) {
  const SpreadFlight flight(two);
  const test::ProgramResult part = test::run_program(flight.node_command("acquisition"));
  EXPECT_EQ(part.exit_status, 2);
  EXPECT_NE(part.output.find("\"acquisition\" is no stage that can run by itself"), std::string::npos) << part.output;
  EXPECT_NE(part.output.find("dense_matcher"), std::string::npos) << part.output;
}

}  // namespace
}  // namespace ilp
