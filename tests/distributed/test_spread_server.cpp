// What happens to the database server of a flight in several processes. Runs with tests/distributed/with_postgres.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "tests/distributed/spread_flight.hpp"
#include "tests/integration/flight_files.hpp"

namespace ilp {
namespace {

using test::SpreadFlight;

const std::vector<std::string> three = {"head,storage_manager",
                                        "overlap_checker,camera_calibrator,structure_and_motion",
                                        "dense_matcher,richness_scorer,compressor,place_memory"};

void sleep_ms(int milliseconds) {
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

test::ProgramResult server(const std::string& order) {
  return test::run_program({std::getenv("ILP_POSTGRES_SERVER"), order});
}

class SpreadServer : public testing::Test {
 protected:
  void SetUp() override {
    if (!SpreadFlight::on_server()) GTEST_SKIP() << "run it with tests/distributed/with_postgres";
  }
  /// Lets the flight go on, does this to the server, and again, until the flight has ended.
  template <typename Disturb>
  void expect_same_in_spite_of(Disturb disturb) {
    SpreadFlight flight(three);
    flight.start_all();
    int disturbances = 0;
    for (int waited = 0; !flight.keep_up(); waited += 300) {
      ASSERT_LT(waited, 120'000) << "no end; the head says: " << flight.output(0);
      sleep_ms(300);
      // Processes that have yet to begin are not connected again; they start again.
      if (disturbances == 4 || flight.output(1).find("running") == std::string::npos) continue;
      disturb();
      ++disturbances;
    }
    EXPECT_GT(disturbances, 2);
    EXPECT_EQ(flight.digest(), test::digest_of_one_process());
    EXPECT_NE(flight.output(0).find("connected to the store again"), std::string::npos) << flight.output(0);
  }
};

TEST_F(SpreadServer, RestartedItIsConnectedAgainAndTheFlightIsTheSame) {
  expect_same_in_spite_of([] { EXPECT_EQ(server("restart").exit_status, 0); });
}

TEST_F(SpreadServer, KilledItLosesNothingThatWasCommitted) {
  expect_same_in_spite_of([] {
    server("kill");
    sleep_ms(200);
    EXPECT_EQ(server("start").exit_status, 0);
  });
}

TEST_F(SpreadServer, APasswordIsNeverAskedForOnTheCommandLine) {
  for (const std::string store :
       {"postgresql://ilp:secret@127.0.0.1/ilp", "postgresql://127.0.0.1/ilp?password=secret"}) {
    const test::ProgramResult result = test::run_program({ILP_ONBOARD, "--stages", "compressor", "--store", store});
    EXPECT_EQ(result.exit_status, 2);
    EXPECT_NE(result.output.find("PGPASSFILE"), std::string::npos) << result.output;
    EXPECT_EQ(result.output.find("secret"), std::string::npos) << result.output;
  }
}

TEST_F(SpreadServer, AWrongPasswordIsSaid) {
  const test::TemporaryFolder folder;
  test::write_file(folder / "passfile", "*:*:*:*:wrong\n");
  std::filesystem::permissions(folder / "passfile", std::filesystem::perms::owner_read);
  std::string port = std::getenv("ILP_POSTGRES_TCP");
  port = port.substr(port.find("port=") + 5);
  port = port.substr(0, port.find(' '));
  const test::ProgramResult result =
      test::run_program({"/usr/bin/env", "PGPASSFILE=" + (folder / "passfile"), ILP_ONBOARD, "--stages", "compressor",
                         "--store", "postgresql://ilp@127.0.0.1:" + port + "/ilp"});
  EXPECT_EQ(result.exit_status, 1) << result.output;
  EXPECT_NE(result.output.find("the database refuses this process"), std::string::npos) << result.output;
  EXPECT_EQ(result.output.find("wrong"), std::string::npos) << result.output;
}

}  // namespace
}  // namespace ilp
