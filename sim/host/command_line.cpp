#include "sim/host/command_line.hpp"

#include <charconv>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

#include "sim/host/text_format.hpp"

namespace ilp::host {
namespace {

void describe(CLI::App& app, const std::string& example, const std::string& statuses) {
  app.footer("Example: " + example + "\n" + statuses);
}

template <typename Number>
std::string fault_of(const std::string& word, const char* what) {
  Number value{};
  const char* const end = word.data() + word.size();
  const auto [rest, error] = std::from_chars(word.data(), end, value);
  bool good = error == std::errc() && rest == end;
  if constexpr (std::is_floating_point_v<Number>) good = good && std::isfinite(value);
  return good ? std::string() : "'" + word + "' is no " + what;
}

std::string fault_of_whole(std::string& word) {
  return fault_of<std::int64_t>(word, "whole number");
}

std::string fault_of_count(std::string& word) {
  return fault_of<std::uint64_t>(word, "whole number from 0 to 18446744073709551615");
}

std::string fault_of_number(std::string& word) {
  return fault_of<double>(word, "finite number");
}

/// CLI11 takes -1 as the largest number, cuts what is too large, and finds that "nan" is in every range.
void check_numbers(CLI::App& app) {
  for (CLI::Option* const option : app.get_options()) {
    // What has to be given has no default.
    if (option->get_required() || option->get_default_str() == "[]") option->default_str("");
    const std::string type = option->get_type_name();
    if (type.starts_with("UINT")) option->check(CLI::Validator(fault_of_count, ""));
    if (type.starts_with("INT")) option->check(CLI::Validator(fault_of_whole, ""));
    if (type.starts_with("FLOAT")) option->check(CLI::Validator(fault_of_number, ""));
  }
  for (CLI::App* const command : app.get_subcommands({})) check_numbers(*command);
}

std::vector<std::string> options_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* const option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// What is wrong with the first word that nobody has asked for; empty where there is none, or another thing is wrong.
std::string unknown_word(const CLI::App& app) {
  const CLI::App* called = &app;
  while (!called->get_subcommands().empty()) called = called->get_subcommands().front();
  std::vector<std::string> commands;
  for (const CLI::App* const command : called->get_subcommands({})) commands.push_back(command->get_name());
  for (const std::string& word : app.remaining(true)) {
    if (word.starts_with("-") && word.size() > 1) {
      const std::string name = word.substr(0, word.find('='));
      return name + " is no option" + did_you_mean(name, options_of(*called));
    }
    if (!commands.empty()) return word + " is no subcommand" + did_you_mean(word, commands);
  }
  return {};
}

}  // namespace

CommandLine::CommandLine(const std::string& name, const std::string& what, const std::string& example,
                         const std::string& statuses)
    : CLI::App(what, name) {
  option_defaults()->always_capture_default();
  describe(*this, example, statuses);
}

CLI::App& add_subcommand(CLI::App& app, const std::string& name, const std::string& what, const std::string& example,
                         const std::string& statuses) {
  CLI::App& command = *app.add_subcommand(name, what);
  describe(command, example, statuses);
  return command;
}

std::optional<int> read_command_line(CLI::App& app, int argc, char** argv, std::ostream& out, std::ostream& err) {
  check_numbers(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, out, err);
    const std::string unknown = unknown_word(app);
    err << app.get_name() << ": " << (unknown.empty() ? error.what() : unknown)
        << "\nRun with --help for more information.\n";
    return wrong_usage;
  }
  return std::nullopt;
}

std::optional<int> read_command_line(CLI::App& app, int argc, char** argv) {
  return read_command_line(app, argc, argv, std::cout, std::cerr);
}

}  // namespace ilp::host
