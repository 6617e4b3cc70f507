#include "sim/tools/lab/lab.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <ostream>
#include <vector>

#include "sim/host/command_line.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/version_line.hpp"

namespace ilp::lab {
namespace {

bool is_result(StatusCode code) {
  switch (code) {
    case StatusCode::ok:
    case StatusCode::too_few_matches:
    case StatusCode::no_model:
    case StatusCode::too_little_parallax:
    case StatusCode::numerical_failure:
    case StatusCode::rectification_impossible:
    case StatusCode::disparity_range_exceeded:
    case StatusCode::coefficient_overflow:
    case StatusCode::grant_too_small:
      return true;
    default:
      return false;
  }
}

}  // namespace

CLI::App& Lab::add(const std::string& name, const std::string& description, const std::string& example,
                   Command command) {
  auto entry = std::make_unique<Entry>();
  entry->app = &host::add_subcommand(app_, name, description, "ilp-lab " + name + " " + example);
  entry->command = std::move(command);
  entry->app
      ->add_option("--repeat", entry->repeat, "number of runs that are timed after a warm-up; the median is printed")
      ->check(CLI::Range(1, 1000000));
  entries_.push_back(std::move(entry));
  return *entries_.back()->app;
}

Json Lab::run() const {
  for (const auto& entry : entries_) {
    if (entry->app->parsed()) return entry->command(entry->repeat);
  }
  throw UsageError("name a subcommand");
}

int run_lab(int argc, char** argv, std::ostream& out, std::ostream& err) {
  constexpr int bad_input = 1;
  host::CommandLine app("ilp-lab", "Runs one onboard kernel on files and prints one JSON object; select prints a table",
                        "ilp-lab overlap 0001.png 0002.png");
  app.require_subcommand(1);
  app.set_version_flag("--version", host::version_line("ilp-lab"));
  Lab lab(app);
  add_match_commands(lab);
  add_two_view_commands(lab);
  add_bundle_command(lab);
  add_calibrate_target_command(lab);
  add_rectify_command(lab);
  add_stereo_command(lab);
  add_encode_command(lab);
  add_richness_command(lab);
  add_pose_strip_command(lab);
  add_select_command(lab);
  add_world_map_command(lab);
  if (const auto end = host::read_command_line(app, argc, argv, out, err)) return *end;
  const std::string name = "ilp-lab " + app.get_subcommands().front()->get_name() + ": ";
  try {
    const Json result = lab.run();
    const std::string text = result.is_string() ? result.get<std::string>() : result.dump(2) + "\n";
    if (!(out << text).flush()) throw std::runtime_error("standard output cannot be written");
    return 0;
  } catch (const UsageError& error) {
    err << name << error.what() << "\n";
    return host::wrong_usage;
  } catch (const std::exception& error) {
    err << name << error.what() << "\n";
    return bad_input;
  }
}

CLI::Validator finite_in(double low, double high) {
  const auto text_of = [](double value) {
    char buffer[32];
    return std::string(buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr);
  };
  const std::string range = "[" + text_of(low) + ", " + text_of(high) + "]";
  return {[low, high, range](std::string& word) {
            double value = 0;
            const char* const end = word.data() + word.size();
            const auto [rest, error] = std::from_chars(word.data(), end, value);
            const bool good = error == std::errc() && rest == end && value >= low && value <= high;
            return good ? std::string() : "'" + word + "' is not a number in " + range;
          },
          "in " + range};
}

std::string verdict_of(const Status& status, const std::string& what) {
  if (!is_result(status.code)) host::require(status, what);
  return status_name(status.code);
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

double time_kernel(int repeat, const std::function<void()>& prepare, const std::function<void()>& kernel) {
  using Clock = std::chrono::steady_clock;
  if (repeat > 1) {
    prepare();
    kernel();
  }
  std::vector<double> times_ms;
  for (int i = 0; i < repeat; ++i) {
    prepare();
    const Clock::time_point begin = Clock::now();
    kernel();
    times_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
  }
  return median(std::move(times_ms));
}

}  // namespace ilp::lab
