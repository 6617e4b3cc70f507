// ilp-parameter-faults: small flights commanded at the limits of what can be commanded, and of what a flight bears. One
// command prints one table.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "tests/faults/parameters/trial_flight.hpp"

int main(int argc, char** argv) {
  using namespace ilp::faults;
  CampaignOptions options;
  std::string campaign;
  CLI::App app(
      "Commands small flights at their limits and prints how the ground reaches them afterwards. Exit status 1: a "
      "flight crashed, hung or was lost");
  app.add_option("campaign", campaign)
      ->required()
      ->check(CLI::IsMember({"parameters", "telecommands", "restarts", "line-rate"}));
  app.add_option("--random", options.random, "number of random combinations of parameters, or of sequences of restarts")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--every", options.every, "fly only one in this many of the other trials")->check(CLI::PositiveNumber);
  app.add_option("--seconds", options.seconds, "mission time of a campaign at line rate")->check(CLI::PositiveNumber);
  app.add_option("--seed", options.seed, "seed of the combinations");
  app.add_option("--trial", options.only, "number of a single trial");
  app.add_option("--jobs", options.jobs, "number of processes")->check(CLI::Range(1, 64));
  CLI11_PARSE(app, argc, argv);
  testing::InitGoogleTest();
  try {
    bool (*const fly)(const CampaignOptions&) = campaign == "parameters"     ? parameter_trials
                                                : campaign == "telecommands" ? telecommand_trials
                                                : campaign == "restarts"     ? restart_trials
                                                                             : line_rate_trials;
    return fly(options) ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ilp-parameter-faults: %s\n", error.what());
    return 2;
  }
}
