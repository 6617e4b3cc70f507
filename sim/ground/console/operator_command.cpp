#include "sim/ground/console/operator_command.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "cfg/mission.hpp"
#include "cfg/mission_text.hpp"
#include "cfg/schedule.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/packets/service_functions.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "sim/ground/console/telecommand_data.hpp"
#include "sim/ground/console/utc_text.hpp"
#include "sim/host/mission_input.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::console {
namespace {

using Kind = OperatorCommand::Kind;
using Words = std::vector<std::string>;  // the words after the command's name

struct Context {
  const Tailoring& tailoring;
  UtcNs now;
};

[[noreturn]] void refuse(const std::string& what) {
  throw std::runtime_error(what);
}

template <typename Number>
Number number(const std::string& text, Number least, Number most, const char* what) {
  Number value{};
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end || !(value >= least && value <= most)) {
    std::ostringstream range;
    range << what << " must be a number from " << least << " to " << most << ", not " << text;
    refuse(range.str());
  }
  return value;
}

std::uint32_t u32(const std::string& text, std::uint32_t least, const char* what) {
  return number<std::uint32_t>(text, least, 0xFFFFFFFFU, what);
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

/// The place of `text` in `names`, which are the values from 0.
std::uint8_t choice(const std::string& text, const std::vector<std::string>& names) {
  const auto found = std::find(names.begin(), names.end(), text);
  if (found != names.end()) return static_cast<std::uint8_t>(found - names.begin());
  refuse(joined(names, " or ") + " is expected, not " + text + host::did_you_mean(text, names));
}

/// Of a longer list: `what` has its article.
[[noreturn]] void refuse_word(const char* what, const std::string& text, const std::vector<std::string>& names) {
  refuse(std::string(what) + " is one of " + joined(names, ", ") + ", not " + text + host::did_you_mean(text, names));
}

OperatorCommand telecommand(std::uint8_t service, std::uint8_t subtype, std::vector<std::uint8_t> data = {}) {
  OperatorCommand command;
  command.kind = Kind::telecommand;
  command.service = service;
  command.subtype = subtype;
  command.data = std::move(data);
  return command;
}

OperatorCommand call(const char* name, const std::vector<std::uint8_t>& arguments = {}) {
  return telecommand(function_management::service, function_management::perform, function(name, arguments));
}

std::vector<std::uint8_t> octets_of(std::uint32_t value) {
  return data_of([&](ByteWriter& out) { out.u32(value); });
}

UtcNs instant(const std::string& text, const Context& context) {
  const std::optional<UtcNs> utc = parse_instant(text, context.now);
  if (!utc) refuse("a time is +SECONDS or 2026-11-22T08:40:00Z, not " + text);
  return *utc;
}

OperatorCommand ping(const Words&, const Context&) {
  return telecommand(test_service::service, test_service::are_you_alive);
}

OperatorCommand capture(const Words& words, const Context& context) {
  if (words.empty()) return call("CAPTURE");
  const UtcNs at = instant(words[0], context);
  return call("CAPTAT", data_of([&](ByteWriter& out) {
                host::require(encode_time(context.tailoring.time, at, out), "the time of a capture");
              }));
}

OperatorCommand series(const Words& words, const Context& context) {
  const UtcNs at = instant(words[0], context);
  const double interval_s = number(words[1], 0.001, 4e6, "the interval in seconds");
  const auto images = number<std::uint16_t>(words[2], 1, 65535, "the number of images");
  return call("CAPTSER", data_of([&](ByteWriter& out) {
                host::require(encode_time(context.tailoring.time, at, out), "the time of a capture");
                out.u32(static_cast<std::uint32_t>(std::lround(interval_s * 1000)));
                out.u16(images);
              }));
}

OperatorCommand mode(const Words& words, const Context&) {
  return call("CAPMODE", {choice(words[0], {"regular", "forecast", "telecommand"})});
}

std::size_t parameter_of(const std::string& name) {
  const std::size_t dot = name.find('.');
  if (dot == std::string::npos)
    refuse("a parameter is written section.key, not " + name + ": " + host::unknown_parameter(name));
  const std::size_t index = find_parameter(name.substr(0, dot).c_str(), name.substr(dot + 1).c_str());
  if (index == parameter_count())
    refuse("there is no parameter " + name + " (docs/parameters.md)" +
           host::did_you_mean(name, host::parameter_names()));
  return index;
}

/// As a mission file has it: an angle may be in degrees.
double setting_value(const ParameterInfo& info, const std::string& text) {
  double value = 0;
  if (parse_value(info, text.c_str(), value) && value >= info.minimum && value <= info.maximum) return value;
  refuse(std::string(info.section) + "." + info.key + " = " + text + ": " + host::fault_of_value(info, text));
}

OperatorCommand set(const Words& words, const Context& context) {
  const std::size_t index = parameter_of(words[0]);
  const ParameterInfo& info = parameter_info(index);
  const double value = setting_value(info, words[1]);
  return telecommand(parameter_management::service, parameter_management::set, data_of([&](ByteWriter& out) {
                       write_count(context.tailoring.parameter_count, 1, out);
                       out.number(info.number, context.tailoring.parameter_id);
                       write_value(info.type, value, out);
                     }));
}

OperatorCommand get(const Words& words, const Context& context) {
  return telecommand(parameter_management::service, parameter_management::report, data_of([&](ByteWriter& out) {
                       write_count(context.tailoring.parameter_count, words.size(), out);
                       for (const std::string& name : words) {
                         out.number(parameter_info(parameter_of(name)).number, context.tailoring.parameter_id);
                       }
                     }));
}

OperatorCommand downlink(const Words& words, const Context&) {
  if (words[0] == "end") return call("PASSEND");
  return call("PASSBEG", octets_of(u32(words[0], 1, "the length of the pass in seconds (or the word end)")));
}

std::uint32_t transaction(const std::string& text) {
  return text == "all" ? 0 : u32(text, 1, "the number of the transfer (or the word all)");
}

OperatorCommand hold(const Words& words, const Context&) {
  return call("XFERSUSP", octets_of(transaction(words[0])));
}
OperatorCommand resume(const Words& words, const Context&) {
  return call("XFERRESU", octets_of(transaction(words[0])));
}
OperatorCommand cancel(const Words& words, const Context&) {
  return call("XFERCANC", octets_of(transaction(words[0])));
}

OperatorCommand refine(const Words& words, const Context&) {
  return call("REFINE", octets_of(u32(words[0], 1, "the keyframe")));
}

OperatorCommand abandon(const Words& words, const Context&) {
  std::vector<std::uint8_t> arguments = octets_of(u32(words[0], 1, "the keyframe"));
  arguments.push_back(choice(words[1], {"depth", "image"}));
  return call("PRODDEL", arguments);
}

OperatorCommand strip(const Words& words, const Context&) {
  return call(choice(words[0], {"begin", "end"}) == 0 ? "STRIPBEG" : "STRIPEND");
}

OperatorCommand flush(const Words&, const Context&) {
  return call("FLUSH");
}

OperatorCommand safe(const Words& words, const Context&) {
  return call("SAFEMODE", {choice(words[0], {"off", "on"})});
}

OperatorCommand restart(const Words& words, const Context&) {
  std::vector<std::string> names;
  for (const Stage& stage : schedule) {
    if (words[0] == stage.name) return call("RESTART", {static_cast<std::uint8_t>(stage.component)});
    names.emplace_back(stage.name);
  }
  refuse_word("a component", words[0], names);
}

struct FunctionText {
  const char* name;
  const char* arguments;
};
constexpr FunctionText functions[] = {
#define FUNCTION(number, effect, name, arguments, completion, meaning) {name, arguments},
#include "fsw/commanding/functions.inc"
};

/// Any function of service 8: its arguments are written in the order and with the types of its row.
OperatorCommand named_function(const Words& words, const Context& context) {
  std::vector<std::string> names;
  for (const FunctionText& row : functions) names.emplace_back(row.name);
  const auto* row = std::find_if(std::begin(functions), std::end(functions),
                                 [&](const FunctionText& function) { return words[0] == function.name; });
  if (row == std::end(functions)) refuse_word("a function", words[0], names);
  const std::string form = "call " + words[0] + " " + row->arguments;
  std::size_t used = 1;
  const auto next = [&]() -> const std::string& {
    if (used == words.size()) refuse("it is written: " + form);
    return words[used++];
  };
  constexpr double largest = std::numeric_limits<double>::max();
  const auto data = data_of([&](ByteWriter& out) {
    std::istringstream types(row->arguments);
    for (std::string type; types >> type;) {
      if (type.starts_with("TIME"))
        host::require(encode_time(context.tailoring.time, instant(next(), context), out), "the time");
      if (type == "u8") out.u8(static_cast<std::uint8_t>(number<std::uint16_t>(next(), 0, 0xFF, "a u8")));
      if (type == "u16") out.u16(number<std::uint16_t>(next(), 0, 0xFFFF, "a u16"));
      if (type == "u32") out.u32(u32(next(), 0, "a u32"));
      if (type == "f64") out.f64(number<double>(next(), -largest, largest, "an f64"));
    }
  });
  if (used < words.size()) refuse("it is written: " + form);
  return call(row->name, data);
}

OperatorCommand uplink(const Words& words, const Context&) {
  OperatorCommand command;
  command.kind = Kind::uplink;
  command.path = words[0];
  return command;
}

OperatorCommand activate(const Words& words, const Context&) {
  return call("ACTIVATE", octets_of(u32(words[0], 1, "the number of the file")));
}

OperatorCommand scheduled(const Words&, const Context&) {
  return telecommand(scheduling::service, scheduling::summary_all);
}

OperatorCommand show(const Words& words, const Context&) {
  std::vector<std::string> names;
  for (const ReportInfo& report : report_table()) {
    if (words[0] == report.name) {
      OperatorCommand command;
      command.kind = Kind::show;
      command.report = report.name;
      return command;
    }
    names.emplace_back(report.name);
  }
  refuse_word("a report", words[0], names);
}

OperatorCommand passes(const Words&, const Context&) {
  OperatorCommand command;
  command.kind = Kind::passes;
  return command;
}

OperatorCommand wait(const Words& words, const Context&) {
  OperatorCommand command;
  command.kind = Kind::wait;
  command.seconds = number(words[0], 0.0, 1e6, "the time to wait in seconds");
  return command;
}

OperatorCommand help(const Words&, const Context&) {
  OperatorCommand command;
  command.kind = Kind::help;
  return command;
}

OperatorCommand quit(const Words&, const Context&) {
  OperatorCommand command;
  command.kind = Kind::quit;
  return command;
}

struct CommandInfo {
  const char* name;
  const char* arguments;
  std::size_t least, most;  // words after the name
  const char* meaning;
  OperatorCommand (*make)(const Words&, const Context&);
};

constexpr CommandInfo commands[] = {
    {"ping", "", 0, 0, "asks the flight for an answer", ping},
    {"capture", "[TIME]", 0, 1, "takes an image now, or at a time: +SECONDS or 2026-11-22T08:40:00Z", capture},
    {"series", "TIME INTERVAL_S NUMBER", 3, 3, "takes images at equal intervals", series},
    {"mode", "regular|forecast|telecommand", 1, 1, "sets what decides when images are taken", mode},
    {"set", "SECTION.KEY VALUE", 2, 2, "sets a parameter", set},
    {"get", "SECTION.KEY...", 1, limits::max_list_items, "asks for parameters", get},
    {"downlink", "SECONDS|end", 1, 1,
     "begins contact for a time, or ends it until the next pass (without passes: at most 120 s)", downlink},
    {"hold", "TRANSFER|all", 1, 1, "suspends the transfer of a file to the ground", hold},
    {"resume", "TRANSFER|all", 1, 1, "resumes a suspended transfer", resume},
    {"cancel", "TRANSFER|all", 1, 1, "cancels the transfer of a file to the ground", cancel},
    {"refine", "KEYFRAME", 1, 1, "sends the products of a keyframe before others", refine},
    {"delete", "KEYFRAME depth|image", 2, 2, "abandons a product that is on board", abandon},
    {"strip", "begin|end", 1, 1, "lets the next image begin a strip, or ends the open strip", strip},
    {"flush", "", 0, 0, "ends the open strip; completed when its poses are final", flush},
    {"safe", "on|off", 1, 1, "switches safe mode: few images, no products", safe},
    {"restart", "COMPONENT", 1, 1, "restarts a component from its checkpoint", restart},
    {"call", "FUNCTION [ARGUMENT]...", 1, 5, "calls any function of service 8 (docs/commanding.md)", named_function},
    {"uplink", "FILE.ini|MAP_FOLDER", 1, 1,
     "sends a file of parameters, whose number the event uplink_received has, or all files of a map", uplink},
    {"activate", "NUMBER", 1, 1, "sets the parameters of an uplinked file", activate},
    {"schedule", "", 0, 0, "lists the telecommands in the schedule", scheduled},
    {"show", "REPORT", 1, 1, "shows all values of a housekeeping report", show},
    {"passes", "", 0, 0, "lists the next passes", passes},
    {"wait", "SECONDS", 1, 1, "waits before the next line, for scripts", wait},
    {"help", "", 0, 0, "shows this list", help},
    {"quit", "", 0, 0, "ends the console, not the flight", quit},
};

std::string written(const CommandInfo& info) {
  return info.name + (*info.arguments ? " " + std::string(info.arguments) : std::string());
}

}  // namespace

OperatorCommand parse_operator_command(const std::string& line, const Tailoring& tailoring, UtcNs now) {
  std::istringstream in(line);
  std::string name;
  if (!(in >> name) || name[0] == '#') return {};
  Words words;
  std::string typed = name;
  for (std::string word; in >> word; typed += " " + word) words.push_back(word);
  const auto* info = std::find_if(std::begin(commands), std::end(commands),
                                  [&](const CommandInfo& command) { return name == command.name; });
  if (info == std::end(commands)) {
    std::vector<std::string> names;
    for (const CommandInfo& command : commands) names.emplace_back(command.name);
    refuse("there is no command " + name + "; help lists them" + host::did_you_mean(name, names));
  }
  if (words.size() < info->least || words.size() > info->most) refuse("it is written: " + written(*info));
  OperatorCommand command = info->make(words, {tailoring, now});
  command.words = typed;
  return command;
}

namespace {

std::vector<std::string> words_of_table(const char* text) {
  std::vector<std::string> words;
  std::string word;
  for (const char* c = text;; ++c) {
    const bool lower = *c == '-' || *c == '_' || (*c >= 'a' && *c <= 'z');
    if (lower) word += *c;
    if (!lower && !word.empty()) words.push_back(std::exchange(word, {}));
    if (*c == '\0') return words;
  }
}

/// What may stand behind the command's name as its first word.
std::vector<std::string> first_arguments(const CommandInfo& info) {
  std::vector<std::string> words;
  const std::string name = info.name;
  if (name == "set" || name == "get") {
    words = host::parameter_names();
  } else if (name == "show") {
    for (const ReportInfo& report : report_table()) words.emplace_back(report.name);
  } else if (name == "restart") {
    for (const Stage& stage : schedule) words.emplace_back(stage.name);
  } else if (name == "call") {
    for (const FunctionText& row : functions) words.emplace_back(row.name);
  } else {
    words = words_of_table(info.arguments);
  }
  return words;
}

}  // namespace

std::string missing_words(const OperatorCommand& command) {
  FunctionCall called;
  if (command.service != function_management::service || !decode_function(command.data, called).ok()) return "";
  const std::string name(called.name, strnlen(called.name, function_name_bytes));
  const std::string number = called.arguments.size() < 4 ? "" : std::to_string(ByteReader(called.arguments).u32());
  if (name.starts_with("XFER")) {
    if (number == "0")
      return "no file is on its way to the ground. To do: nothing; the line `queue` shows the newest one";
    return "no file on its way to the ground has the number " + number +
           ". To do: take the number from the line `queue`, or from `show transfer`; one that was delivered has none";
  }
  if (name == "REFINE" || name == "PRODDEL") {
    return "no such product of keyframe " + number +
           " is on board. To do: `show product` and `show keyframe` have the newest ones; a product is made some "
           "keyframes later, and is gone once it is confirmed";
  }
  if (name == "ACTIVATE")
    return "no file of parameters with the number " + number +
           " is on board. To do: send it by `uplink FILE.ini`; the event uplink_received states its number";
  return "";
}

std::vector<std::string> complete_operator_line(const std::string& typed) {
  std::vector<std::string> lines;
  const std::size_t blank = typed.find(' ');
  for (const CommandInfo& info : commands) {
    if (blank == std::string::npos) {
      const std::string line = info.name + std::string(*info.arguments ? " " : "");
      if (line.starts_with(typed)) lines.push_back(line);
    } else if (typed.substr(0, blank) == info.name) {
      for (const std::string& word : first_arguments(info)) {
        const std::string line = info.name + (" " + word);
        if (line.starts_with(typed)) lines.push_back(line);
      }
    }
  }
  return lines;
}

std::vector<std::string> operator_help() {
  std::size_t width = 0;
  for (const CommandInfo& info : commands) width = std::max(width, written(info).size());
  std::vector<std::string> lines;
  for (const CommandInfo& info : commands) {
    std::string left = written(info);
    left.resize(width + 2, ' ');
    lines.push_back(left + info.meaning);
  }
  return lines;
}

}  // namespace ilp::console
