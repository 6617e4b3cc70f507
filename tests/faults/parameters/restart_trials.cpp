// Operators who set what decides about contact, kills at any call that changes a file, and calendars that jump: the
// ground gets back in with the last good configuration, and no other one ever takes its place.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <stdexcept>

#include "fsw/base/rng.hpp"
#include "fsw/commanding/configuration.hpp"
#include "fsw/packets/tailoring.hpp"
#include "tests/faults/parameters/kill_at_write.hpp"
#include "tests/faults/parameters/trial_flight.hpp"

namespace ilp::faults {
namespace {

using test::Octets;

constexpr std::uint16_t spi = 7;
constexpr std::size_t most_parameters = 192;
/// Of the calls of a process that change a file; a start makes some dozens.
constexpr std::uint32_t farthest_kill = 300;
/// Of one parameter the values of which one is the good one: a kill leaves it open which.
constexpr std::size_t most_allowed = 4;
constexpr double wait_s = 5;

struct Choice {
  const char* section;
  const char* key;
  std::vector<double> values;
};

/// What decides about contact, what takes effect with a start, and one that does neither.
const std::vector<Choice>& choices() {
  static const std::vector<Choice> list = {
      {"downlink", "link_bytes_per_s", {0, 50, 200000}},
      {"downlink", "pass_period_s", {0, 300, 1e7}},
      {"downlink", "pass_length_s", {1, 100, 600}},
      {"downlink", "pass_start_s", {0, 500, 1e9}},
      {"downlink", "pass_count", {0, 1}},
      {"link", "telecommands_per_s", {1, 10, 200}},
      {"link", "authentication", {0, 1, 2}},
      {"link", "apid", {239, 300, 17}},
      {"link", "tailoring", {0, 1, 2}},
      {"link", "cuc_time", {0, 1}},
      {"link", "mission_epoch_s", {2'145'916'800, 2'145'000'000}},
      {"link", "cfdp_sequence_octets", {2, 4}},
      {"calibration", "camera_known", {0, 1}},
      {"contact", "trial_s", {60, 100}},
      {"contact", "closed_until_s", {0, 1e9}},
      {"motion", "corners", {500, 1000}},
  };
  return list;
}

/// What the ground knows, and what is true whatever happens to the flight. Lies in shared memory.
struct Truth {
  /// The value under which a telecommand was answered last: any of these.
  double allowed[most_parameters][most_allowed];
  std::size_t alternatives[most_parameters];
  double latest_set[most_parameters];
  double in_force[most_parameters];  ///< when the present telecommand was sent
  bool open;                         ///< it is not known yet whether it was accepted
  bool known;
  std::size_t set_index;  ///< of the present telecommand; most_parameters: it sets none
  double set_value;
  std::int64_t calendar_s;
  std::uint32_t sequence;
  std::int64_t starts, kills, telecommands, confirmations;
  char fault[160];

  void allow(std::size_t index, double value) {
    for (std::size_t i = 0; i < alternatives[index]; ++i) {
      if (allowed[index][i] == value) return;
    }
    if (alternatives[index] < most_allowed) allowed[index][alternatives[index]++] = value;
  }
  void allow_only(std::size_t index, double value) {
    alternatives[index] = 0;
    allow(index, value);
  }
  [[nodiscard]] bool allows(std::size_t index, double value) const {
    for (std::size_t i = 0; i < alternatives[index]; ++i) {
      if (allowed[index][i] == value) return true;
    }
    return false;
  }
};

/// One process of the flight, from a start to its kill or end.
class Process {
 public:
  Process(test::FlightBoard& board, Truth& truth) : board_(board), truth_(truth) {}

  [[nodiscard]] bool start() {
    board_.calendar_s = truth_.calendar_s;
    ++truth_.starts;
    if (!board_.start().ok()) return broken("it does not start", 0, 0);
    return check();
  }
  /// A telecommand at the address of the last good configuration, or of the latest one that was set.
  [[nodiscard]] bool act(Rng& random) {
    const bool at_good = random.below(4) != 0;
    const std::uint32_t kind = random.below(10);
    truth_.set_index = most_parameters;
    if (kind < 5) {
      const Choice& choice = choices()[random.below(static_cast<std::uint32_t>(choices().size()))];
      truth_.set_index = find_parameter(choice.section, choice.key);
      truth_.set_value = choice.values[random.below(static_cast<std::uint32_t>(choice.values.size()))];
    } else if (kind == 9) {
      board_.fly_on(static_cast<double>(random.below(140)));
      return go_on();
    }
    return telecommand(at_good) && go_on();
  }
  /// Answered at the address of the last good configuration.
  bool ping() {
    truth_.set_index = most_parameters;
    return telecommand(true) && accepted_;
  }
  Fate reach() {
    if (ping()) return Fate::answered;
    for (int i = 0; i < 40; ++i) {
      board_.fly_on(10);
      if (!go_on()) return Fate::other_answer;
      if (ping()) return Fate::trial;
    }
    for (int start = 0; start < 6; ++start) {
      if (!board_.restart().ok()) return Fate::no_start;
      if (!check()) return Fate::other_answer;
      if (ping()) return Fate::starts;
    }
    return Fate::lost;
  }

 private:
  bool broken(const char* what, double value, double other) {
    if (truth_.fault[0] == 0)
      std::snprintf(truth_.fault, sizeof(truth_.fault), "%s (%.10g, %.10g)", what, value, other);
    return false;
  }
  [[nodiscard]] double good(std::size_t index) {
    const FlightMemoryContent& content = board_.memory().content();
    const KeptSetting* const kept = content.good.find(parameter_info(index).number);
    if (kept != nullptr) return kept->value;
    // The epoch is that of the first start.
    const bool epoch = index == find_parameter("link", "mission_epoch_s") && content.epoch_known != 0;
    return epoch ? content.mission_epoch_s : parameter_value(board_.mission_file, index);
  }
  /// The last good configuration is one that is allowed, and from now on the only one.
  bool check() {
    const bool first = !truth_.known;
    for (const Choice& choice : choices()) {
      const std::size_t index = find_parameter(choice.section, choice.key);
      if (first) truth_.allow_only(index, good(index));
      if (!truth_.allows(index, good(index))) return broken(choice.key, good(index), truth_.allowed[index][0]);
      truth_.allow_only(index, good(index));
      const bool last_good = board_.configuration().stage() == ConfigurationStage::last_good;
      const double value = parameter_value(board_.mission, index);
      if (last_good && value != good(index) && !board_.software->executive().frames_run())
        return broken(choice.key, value, good(index));
    }
    truth_.known = true;
    truth_.open = false;
    return true;
  }
  bool go_on() {
    truth_.calendar_s = board_.calendar_now();
    return check();
  }
  [[nodiscard]] double address(const char* section, const char* key, bool of_good) {
    const std::size_t index = find_parameter(section, key);
    return of_good ? good(index) : truth_.latest_set[index];
  }
  bool telecommand(bool at_good) {
    ++truth_.telecommands;
    for (std::size_t i = 0; i < parameter_count(); ++i) truth_.in_force[i] = parameter_value(board_.mission, i);
    const auto authentication = static_cast<Authentication>(address("link", "authentication", at_good));
    board_.apid = static_cast<std::uint16_t>(address("link", "apid", at_good));
    const auto system = static_cast<GroundSystem>(address("link", "tailoring", at_good));
    Octets octets;
    if (truth_.set_index < most_parameters) {
      const Tailoring tailoring = tailoring_of(system, address("link", "cuc_time", at_good) != 0, 0);
      const ParameterInfo& info = parameter_info(truth_.set_index);
      octets.resize(64);
      ByteWriter out(octets);
      write_count(tailoring.parameter_count, 1, out);
      out.number(info.number, tailoring.parameter_id);
      write_value(info.type, truth_.set_value, out);
      octets.resize(out.size());
      octets = board_.packet(parameter_management::service, parameter_management::set, octets);
    } else {
      octets = board_.ping_packet();
    }
    const bool built_in = board_.configuration().stage() == ConfigurationStage::built_in;
    // Its answer comes only if it makes the flight speak again.
    const bool silent = truth_.in_force[find_parameter("downlink", "link_bytes_per_s")] == 0;
    truth_.open = true;
    std::map<std::size_t, double> before;
    for (const Choice& choice : choices()) {
      const std::size_t index = find_parameter(choice.section, choice.key);
      before[index] = good(index);
      // Whether it was accepted is not known if the process is killed. Of the built-in parameters it confirms those
      // that were set so.
      truth_.allow(index, truth_.in_force[index]);
    }
    allow_what_is_set();
    board_.send(authentication == Authentication::none ? octets : board_.sealed(octets, ++truth_.sequence));
    const std::string answer = board_.answers(wait_s);
    accepted_ = answer.find("1.1") != std::string::npos;
    const bool carried_out = answer.find("1.7") != std::string::npos;
    if (accepted_) {
      if (!built_in) ++truth_.confirmations;
      for (const Choice& choice : choices()) {
        const std::size_t index = find_parameter(choice.section, choice.key);
        if (!built_in && !silent) truth_.allow_only(index, truth_.in_force[index]);
        // It may have been accepted behind the end of a trial.
        if (parameter_value(board_.mission, index) == before[index]) truth_.allow(index, before[index]);
      }
      if (carried_out) {
        allow_what_is_set();
        if (truth_.set_index < most_parameters) truth_.latest_set[truth_.set_index] = truth_.set_value;
      }
    }
    if (board_.configuration().restart_wanted() && !board_.restart().ok()) return broken("it does not restart", 0, 0);
    return true;
  }
  /// A parameter that needs no trial is good as soon as it is set.
  void allow_what_is_set() {
    if (truth_.set_index < most_parameters && !needs_confirmation(truth_.set_index))
      truth_.allow(truth_.set_index, truth_.set_value);
  }

  test::FlightBoard& board_;
  Truth& truth_;
  bool accepted_ = false;
};

/// Calendars go both ways, are lost with the power, or stand in the year 2121.
void jump(Rng& random, Truth& truth) {
  switch (random.below(12)) {
    case 0:
      truth.calendar_s -= 1000;
      break;
    case 1:
      truth.calendar_s = 378'691'200;
      break;
    case 2:
      truth.calendar_s = 2'145'916'800 + 2000;
      break;
    case 3:
      truth.calendar_s += 400'000;
      break;
    case 4:
      if (random.below(4) == 0) truth.calendar_s = 2'145'916'800 + 3'000'000'000;
      break;
    default:
      truth.calendar_s += random.below(100);
  }
}

Fate fly(std::int64_t trial, const CampaignOptions& options, Truth& truth) {
  Rng random(options.seed, static_cast<std::uint64_t>(trial));
  test::FlightBoard board;
  board.key_list = {{spi, Octets(32, 0x42)}};
  truth = {};
  truth.calendar_s = board.calendar_s;
  for (std::size_t i = 0; i < parameter_count(); ++i) truth.latest_set[i] = parameter_value(board.mission_file, i);
  const std::uint32_t boots = 2 + random.below(10);
  for (std::uint32_t boot = 0; boot <= boots; ++boot) {
    const bool last = boot == boots;
    const std::uint32_t kill = last || random.below(4) == 0 ? 0 : 1 + random.below(farthest_kill);
    const std::uint32_t actions = 1 + random.below(6);
    const std::uint64_t seed = (std::uint64_t{random.next()} << 32U) | boot;
    const auto live = [&] {
      Rng own(seed, options.seed);
      Process process(board, truth);
      if (!process.start()) _exit(1);
      for (std::uint32_t i = 0; i < actions && !last; ++i) {
        if (!process.act(own)) _exit(1);
      }
      _exit(last ? 10 + static_cast<int>(process.reach()) : 0);
    };
    int status = 0;
    const End end = run_boot(kill, live, status);
    if (end == End::killed) {
      ++truth.kills;
    } else if (end == End::crashed) {
      return Fate::crash;
    } else if (last) {
      return status >= 10 && truth.fault[0] == 0 ? static_cast<Fate>(status - 10) : Fate::other_answer;
    } else if (status != 0) {
      return Fate::other_answer;
    }
    jump(random, truth);
  }
  return Fate::lost;
}

}  // namespace

bool restart_trials(const CampaignOptions& options) {
  static_assert(sizeof(Truth) < (1U << 20U));
  const std::size_t bytes = static_cast<std::size_t>(options.random) * sizeof(Truth);
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no shared memory");
  auto* const truths = static_cast<Truth*>(memory);
  TrialTable table{.rows = {"restarts"}};
  table.trial = [&](std::int64_t trial) { return fly(trial, options, truths[trial]); };
  table.describe = [&](std::int64_t trial) {
    return std::pair<std::size_t, std::string>{0, "random " + std::string(truths[trial].fault)};
  };
  const bool good = run_table(table, options.random, options);
  std::int64_t starts = 0, kills = 0, telecommands = 0, confirmations = 0;
  for (std::int64_t i = 0; i < options.random; ++i) {
    starts += truths[i].starts;
    kills += truths[i].kills;
    telecommands += truths[i].telecommands;
    confirmations += truths[i].confirmations;
  }
  std::printf("%lld starts, %lld kills, %lld telecommands, %lld of them accepted\n", static_cast<long long>(starts),
              static_cast<long long>(kills), static_cast<long long>(telecommands),
              static_cast<long long>(confirmations));
  return good;
}

}  // namespace ilp::faults
