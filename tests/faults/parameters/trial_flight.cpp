#include "tests/faults/parameters/trial_flight.hpp"

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "fsw/packets/pass_schedule.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/renderer.hpp"
#include "sim/world/scenario.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::faults {
namespace {

constexpr int images = 60;
/// Processor time of a trial, so that the load of the machine decides nothing. The longest take a tenth of it.
constexpr int watchdog_seconds = 300;
/// Longer trials are not waited for.
constexpr double longest_trial_s = 600;
constexpr std::size_t most_in_a_request = limits::max_list_items;
/// Passes are at most so far apart.
constexpr TimeNs farthest_pass_ns = 10'000'000 * ns_per_s;

}  // namespace

const char* fate_name(Fate fate) {
  constexpr const char* names[] = {
      "answers",      "refused",      "after its trial", "after a telecommand", "in its pass",
      "after starts", "wrong answer", "no start",        "contact lost",        "hang",
      "crash"};
  static_assert(std::size(names) == static_cast<std::size_t>(Fate::kinds));
  return names[static_cast<std::size_t>(fate)];
}

CameraModel trial_camera() {
  CameraModel camera{160, 120, 137, 137, 79.5, 59.5};
  return camera;
}

std::vector<host::Raster<std::uint8_t>> trial_images() {
  world::Scenario scenario;
  scenario.effects.read_noise_grey = 1;
  scenario.flight.camera = trial_camera();
  scenario.flight.frames = images;
  scenario.flight.interval_s = 3;
  const world::Terrain terrain(scenario.world);
  const world::Trajectory trajectory(scenario.flight);
  const world::Renderer renderer(terrain, scenario.flight.camera, scenario.effects, scenario.flight.seed);
  std::vector<host::Raster<std::uint8_t>> list;
  for (const std::int64_t time : trajectory.exposures()) {
    world::RenderedFrame frame;
    renderer.render(trajectory.motion(time), static_cast<std::int64_t>(list.size()), frame);
    list.push_back(std::move(frame.grey));
  }
  return list;
}

Status TrialCamera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  const std::int64_t number = now / interval_ns;
  if (number <= latest_) return StatusCode::not_ready;
  latest_ = number;
  const auto& picture = images_[static_cast<std::size_t>(number) % images_.size()];
  ILP_TRY(image.resize(picture.width, picture.height));
  std::copy(picture.samples.begin(), picture.samples.end(), image.view().data);
  frame = {};
  frame.time_ns = number * interval_ns;
  frame.sequence = ++sequence_;
  return {};
}

TrialFlight::TrialFlight(const std::vector<host::Raster<std::uint8_t>>& images) : camera_(images) {
  board_.eye = &camera_;
  board_.model = trial_camera();
  board_.key_list = {{7, test::Octets(32, 0x42)}};
}

void TrialFlight::send(int service, int subtype, const test::Octets& data) {
  board_.apid = static_cast<std::uint16_t>(board_.mission.apid);
  const test::Octets plain = board_.packet(service, subtype, data);
  board_.send(board_.mission.authentication != Authentication::none ? board_.sealed(plain, ++sequence_) : plain);
}

std::string TrialFlight::set(const std::map<std::size_t, double>& values) {
  std::string answer;
  for (auto next = values.begin(); next != values.end();) {
    test::Octets octets(4096);
    ByteWriter out(octets);
    const auto left = static_cast<std::size_t>(std::distance(next, values.end()));
    const std::size_t count = std::min(left, most_in_a_request);
    const Tailoring tailoring = tailoring_of(board_.mission.tailoring, board_.mission.cuc_time, 0);
    write_count(tailoring.parameter_count, count, out);
    for (std::size_t i = 0; i < count; ++i, ++next) {
      out.number(parameter_info(next->first).number, tailoring.parameter_id);
      write_value(parameter_info(next->first).type, next->second, out);
    }
    octets.resize(out.size());
    send(parameter_management::service, parameter_management::set, octets);
    answer = board_.answers(0.5);
  }
  return answer;
}

bool TrialFlight::ping() {
  send(17, 1, {});
  return board_.answers(5).find("17.2") != std::string::npos;
}

bool TrialFlight::ping_in_next_pass() {
  const Contact contact = contact_at(board_.mission, board_.clock.now());
  if (contact.over || contact.begin_ns - board_.clock.now() > farthest_pass_ns) return false;
  // Nothing happens until then.
  board_.clock.set(std::max(contact.begin_ns, board_.clock.now()));
  return ping();
}

void TrialFlight::set_built_in() {
  const MissionParameters built_in;
  std::map<std::size_t, double> values;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    // Mission time is not the ground's to go back in.
    if (std::strcmp(parameter_info(i).key, "mission_epoch_s") == 0) continue;
    values[i] = parameter_value(built_in, i);
  }
  set(values);
}

Fate TrialFlight::reach() {
  if (ping()) return Fate::answered;
  // A link that is slow has a queue.
  board_.fly_on(std::min(board_.mission.trial_s, longest_trial_s) + 5);
  if (ping()) return Fate::trial;
  set_built_in();
  board_.fly_on(30);
  if (ping()) return Fate::telecommand;
  if (ping_in_next_pass()) return Fate::pass;
  set_built_in();
  board_.fly_on(30);
  if (ping()) return Fate::pass;
  for (int start = 0; start < 6; ++start) {
    if (!board_.restart().ok()) return Fate::no_start;
    board_.fly_on(5);
    if (ping()) return Fate::starts;
  }
  return Fate::lost;
}

namespace {

void run_apart(const std::function<Fate()>& body, TrialResult& result) {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const itimerval limit{{0, 0}, {watchdog_seconds, 0}};
    setitimer(ITIMER_PROF, &limit, nullptr);
    result.fate = body();
    // A start that the flight asked for has failed.
    if (testing::UnitTest::GetInstance()->ad_hoc_test_result().Failed()) result.fate = Fate::no_start;
    _exit(0);
  }
  int state = 0;
  waitpid(child, &state, 0);
  if (WIFEXITED(state) && WEXITSTATUS(state) == 0) return;
  result.fate = WIFSIGNALED(state) && WTERMSIG(state) == SIGPROF ? Fate::hang : Fate::crash;
}

TrialResult* shared_results(std::int64_t trials) {
  void* const memory = mmap(nullptr, static_cast<std::size_t>(trials) * sizeof(TrialResult), PROT_READ | PROT_WRITE,
                            MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no shared memory");
  return static_cast<TrialResult*>(memory);
}

void print(const TrialTable& table, std::int64_t trials, const TrialResult* results, const std::vector<bool>& flown) {
  constexpr auto kinds = static_cast<std::size_t>(Fate::kinds);
  std::vector<std::array<int, kinds>> counts(table.rows.size());
  for (std::int64_t i = 0; i < trials; ++i) {
    if (flown[static_cast<std::size_t>(i)])
      ++counts[table.describe(i).first][static_cast<std::size_t>(results[i].fate)];
  }
  std::printf("| | trials |");
  for (std::size_t k = 0; k < kinds; ++k) std::printf(" %s |", fate_name(static_cast<Fate>(k)));
  std::printf("\n|---|---|");
  for (std::size_t k = 0; k < kinds; ++k) std::printf("---|");
  std::printf("\n");
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    int sum = 0;
    for (const int count : counts[row]) sum += count;
    std::printf("| %s | %d |", table.rows[row].c_str(), sum);
    for (const int count : counts[row]) std::printf(" %d |", count);
    std::printf("\n");
  }
}

}  // namespace

bool run_table(const TrialTable& table, std::int64_t trials, const CampaignOptions& options) {
  TrialResult* const results = shared_results(trials);
  std::vector<bool> flown(static_cast<std::size_t>(trials));
  for (std::int64_t i = 0; i < trials; ++i) {
    const bool random = table.describe(i).second.rfind("random", 0) == 0;
    flown[static_cast<std::size_t>(i)] =
        options.only >= 0 ? i == options.only : random || i % std::max<std::int64_t>(options.every, 1) == 0;
  }
  std::vector<pid_t> workers;
  for (int worker = 0; worker < options.jobs; ++worker) {
    std::fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      std::int64_t turn = 0;
      for (std::int64_t i = 0; i < trials; ++i) {
        if (!flown[static_cast<std::size_t>(i)] || turn++ % options.jobs != worker) continue;
        run_apart([&] { return table.trial(i); }, results[i]);
      }
      _exit(0);
    }
    workers.push_back(child);
  }
  bool good = true;
  for (const pid_t worker : workers) {
    int state = 0;
    good = waitpid(worker, &state, 0) == worker && WIFEXITED(state) && WEXITSTATUS(state) == 0 && good;
  }
  print(table, trials, results, flown);
  for (std::int64_t i = 0; i < trials; ++i) {
    if (!flown[static_cast<std::size_t>(i)] || (!breaks_promise(results[i].fate) && options.only < 0)) continue;
    std::printf("trial %lld: %s: %s\n", static_cast<long long>(i), fate_name(results[i].fate),
                table.describe(i).second.c_str());
    good = good && !breaks_promise(results[i].fate);
  }
  return good;
}

}  // namespace ilp::faults
