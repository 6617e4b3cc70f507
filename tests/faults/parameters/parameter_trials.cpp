// Every parameter at its minimum, maximum and default, alone, and random combinations: by telecommand, which the flight
// tries, and as its mission file.
#include <cmath>
#include <cstdio>

#include "fsw/base/rng.hpp"
#include "fsw/packets/service_functions.hpp"
#include "sim/ground/console/telecommand_data.hpp"
#include "tests/faults/parameters/trial_flight.hpp"

namespace ilp::faults {
namespace {

using Values = std::map<std::size_t, double>;
constexpr int most_together = 12;
constexpr int most_draws = 200;

struct Plan {
  std::size_t row = 0;
  bool by_file = false;
  Values values;
};

MissionParameters with(const Values& values) {
  MissionParameters mission;
  for (const auto& [index, value] : values) static_cast<void>(set_parameter(mission, index, value));
  return mission;
}

/// As the link carries it.
double on_the_link(std::size_t index, double value) {
  return parameter_info(index).type == FieldType::f64 ? value : std::floor(value);
}

double draw(std::size_t index, Rng& random) {
  const ParameterInfo& info = parameter_info(index);
  const std::uint32_t kind = random.below(5);
  if (kind == 0) return info.minimum;
  if (kind == 1) return info.maximum;
  if (kind == 2) return parameter_value(MissionParameters{}, index);
  const double share = random.uniform();
  // Small values are as likely as large ones, where the range spans decades.
  const bool wide = kind == 3 && info.minimum > 0;
  const double value = wide ? info.minimum * std::pow(info.maximum / info.minimum, share)
                            : info.minimum + share * (info.maximum - info.minimum);
  return std::fmin(std::fmax(value, info.minimum), info.maximum);
}

Plan random_plan(std::uint64_t seed, std::int64_t number) {
  Rng random(seed, static_cast<std::uint64_t>(number));
  Plan plan{.by_file = number % 2 == 1};
  plan.row = plan.by_file ? 4 : 3;
  // Contradictions are the others' business; a combination that cannot be had is drawn again.
  for (int i = 0; i < most_draws; ++i) {
    plan.values.clear();
    const std::uint32_t together = 2 + random.below(most_together - 1);
    for (std::uint32_t k = 0; k < together; ++k) {
      const std::size_t index = random.below(static_cast<std::uint32_t>(parameter_count()));
      plan.values[index] = on_the_link(index, draw(index, random));
    }
    if (validate(with(plan.values)).ok()) break;
  }
  return plan;
}

Plan plan_of(std::int64_t trial, const CampaignOptions& options) {
  const auto alone = static_cast<std::int64_t>(3 * parameter_count());
  if (trial >= alone) return random_plan(options.seed, trial - alone);
  Plan plan;
  const auto index = static_cast<std::size_t>(trial) / 3;
  plan.row = static_cast<std::size_t>(trial) % 3;
  const ParameterInfo& info = parameter_info(index);
  const double value = plan.row == 0   ? info.minimum
                       : plan.row == 1 ? info.maximum
                                       : parameter_value(MissionParameters{}, index);
  plan.values[index] = value;
  return plan;
}

Fate fly(const Plan& plan, const std::vector<host::Raster<std::uint8_t>>& images) {
  TrialFlight flight(images);
  test::FlightBoard& board = flight.board();
  const MissionParameters wanted = with(plan.values);
  const bool valid = validate(wanted).ok();
  if (plan.by_file && !valid) return Fate::refused;
  if (plan.by_file) {
    const double trial_s = board.mission_file.trial_s;
    board.mission_file = wanted;
    if (wanted.trial_s == MissionParameters{}.trial_s) board.mission_file.trial_s = trial_s;
  }
  if (!board.start().ok()) return Fate::no_start;
  board.fly_on(10);
  bool refused = false;
  if (!plan.by_file) {
    const std::string answer = flight.set(plan.values);
    refused = answer.find("1.4") != std::string::npos || answer.find("1.8") != std::string::npos ||
              answer.find("1.2") != std::string::npos;
    if (!valid && !refused) return Fate::other_answer;
  }
  const std::vector<std::uint8_t> capture = console::function("CAPTURE");
  for (int i = 0; i < 4; ++i) {
    board.fly_on(2.5);
    flight.send(8, 1, capture);
  }
  if (!board.restart().ok()) return Fate::no_start;
  board.fly_on(10);
  const Fate fate = flight.reach();
  return refused && fate == Fate::answered ? Fate::refused : fate;
}

std::string text_of(const Plan& plan) {
  std::string text = plan.row < 3 ? "" : plan.by_file ? "random, file:" : "random:";
  for (const auto& [index, value] : plan.values) {
    char item[100];
    std::snprintf(item, sizeof(item), " %s=%.17g", parameter_info(index).key, value);
    text += item;
  }
  return text;
}

}  // namespace

bool parameter_trials(const CampaignOptions& options) {
  const std::vector<host::Raster<std::uint8_t>> images = trial_images();
  TrialTable table;
  table.rows = {"minimum, alone", "maximum, alone", "default, alone", "random, by telecommand", "random, as file"};
  table.trial = [&](std::int64_t trial) { return fly(plan_of(trial, options), images); };
  table.describe = [&](std::int64_t trial) {
    const Plan plan = plan_of(trial, options);
    return std::pair{plan.row, text_of(plan)};
  };
  return run_table(table, static_cast<std::int64_t>(3 * parameter_count()) + options.random, options);
}

}  // namespace ilp::faults
