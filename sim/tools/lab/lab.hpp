// The frame of all subcommands: command line, timing, verdicts, exit status.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <iosfwd>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "fsw/base/status.hpp"
#include "sim/host/command_line.hpp"

namespace ilp::lab {

/// Members keep their order. Numbers that are not finite are written as null.
using Json = nlohmann::ordered_json;

/// A mistake in the command line: exit status 2. Anything else that is thrown is bad input: exit status 1.
using UsageError = host::WrongUsage;

/// Runs a subcommand; the argument is --repeat. What it returns is printed, a string as the text that it is.
using Command = std::function<Json(int repeat)>;

class Lab {
 public:
  explicit Lab(CLI::App& app) : app_(app) {}
  /// A subcommand with --repeat; the caller adds its own options. The example begins behind the name.
  CLI::App& add(const std::string& name, const std::string& description, const std::string& example, Command command);
  /// Runs the subcommand that the parsed command line names.
  [[nodiscard]] Json run() const;

 private:
  struct Entry {
    CLI::App* app = nullptr;
    Command command;
    int repeat = 1;
  };
  CLI::App& app_;
  std::vector<std::unique_ptr<Entry>> entries_;
};

/// The whole program: one JSON object or a text to `out`, or a message to `err`. Returns the exit status.
int run_lab(int argc, char** argv, std::ostream& out, std::ostream& err);

/// A finite number in [low, high]; unlike CLI::Range it refuses NaN.
[[nodiscard]] CLI::Validator finite_in(double low, double high);

/// "ok", or the name of a status that says what the data are like (too few matches, no model, ...): that is a result.
/// std::runtime_error("WHAT: ...") for a status that says the input is wrong.
[[nodiscard]] std::string verdict_of(const Status& status, const std::string& what);

/// Median of values in any order; 0 if there are none.
[[nodiscard]] double median(std::vector<double> values);

/// Median duration, ms, of `kernel`: one run, or, for repeat > 1, that many after a warm-up. `prepare` goes before
/// every run and is not timed.
double time_kernel(int repeat, const std::function<void()>& prepare, const std::function<void()>& kernel);

void add_match_commands(Lab& lab);
void add_two_view_commands(Lab& lab);
void add_bundle_command(Lab& lab);
void add_calibrate_target_command(Lab& lab);
void add_rectify_command(Lab& lab);
void add_stereo_command(Lab& lab);
void add_encode_command(Lab& lab);
void add_richness_command(Lab& lab);
void add_pose_strip_command(Lab& lab);
void add_select_command(Lab& lab);
void add_world_map_command(Lab& lab);

}  // namespace ilp::lab
