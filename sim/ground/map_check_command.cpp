#include "sim/ground/map_check_command.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/ground/fixes/fix_text.hpp"
#include "sim/ground/fixes/map_check.hpp"
#include "sim/ground/maps/map_patches.hpp"
#include "sim/host/command_line.hpp"
#include "sim/host/files.hpp"
#include "sim/host/key_file.hpp"
#include "sim/host/mission_input.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

struct Words {
  std::string mission, key, out;
  std::vector<std::string> senses;
  std::vector<double> sun;
  double evidence = 0, search_px = 0;
};

void add_options(CLI::App& app, Words& words, fixes::MapCheckOptions& options) {
  app.add_option("flight", options.outbox, "folder with the files that came down, or of a flight of ilp-sil")
      ->required();
  app.add_option("map", options.map, "folder of a map (ilp-ground map-tiles, ilp-lab world-map)")->required();
  app.add_option("--mission", words.mission,
                 "mission file of the flight: its parameters of the map, the epoch and the body are used");
  app.add_option("--sun", words.sun,
                 "AZIMUTH,ELEVATION of the sun over the flight, degrees clockwise from north (default: by the calendar "
                 "and the mission's epoch)")
      ->delimiter(',')
      ->expected(2);
  app.add_option("--evidence", words.evidence, "evidence that a fix needs")
      ->default_str("10")
      ->check(CLI::Range(8.0, 100.0));
  app.add_option("--search", words.search_px, "largest search, working pixels")
      ->default_str("40")
      ->check(CLI::Range(16.0, 40.0));
  app.add_option("--senses", words.senses, "what is compared")
      ->default_str("relit,shape,relief")
      ->delimiter(',')
      ->check(CLI::IsMember({"relit", "shape", "relief"}));
  app.add_option("--key", words.key, "file of keys of the flight: the map must be signed with its first key");
  app.add_option("--out", words.out, "JSON file for the fixes");
}

void read_words(const Words& words, fixes::MapCheckOptions& options) {
  options.mission = host::read_mission(words.mission);
  MissionParameters& mission = options.mission;
  options.any_body = words.mission.empty() || mission.body == Body::none;
  if (words.evidence > 0) mission.map_evidence = words.evidence;
  if (words.search_px > 0) mission.map_search_px = words.search_px;
  if (!words.senses.empty()) {
    const std::map<std::string, unsigned> numbers{{"relit", 1}, {"shape", 2}, {"relief", 4}};
    unsigned sum = 0;
    for (const std::string& sense : words.senses) sum |= numbers.at(sense);
    mission.map_senses = static_cast<std::uint8_t>(sum);
  }
  if (!words.sun.empty()) {
    const maps::Sun sun = maps::sun_of("--sun", words.sun[0], words.sun[1], 0);
    mission.map_sun_given = true;
    mission.map_sun_azimuth_rad = sun.azimuth_rad;
    mission.map_sun_elevation_rad = sun.elevation_rad;
  }
  if (!words.key.empty()) options.key = host::read_key_file(words.key).octets;
  // What came down of a flight of ilp-sil.
  if (fs::is_directory(options.outbox / "outbox")) options.outbox /= "outbox";
  if (!fs::is_directory(options.outbox))
    throw std::runtime_error(options.outbox.string() + " is no folder: the files that came down are expected there");
}

/// Verdict, sense, evidence, shift and place of each keyframe.
void print(const fixes::FixSummary& summary, std::ostream& out) {
  for (const fixes::StripFixes& strip : summary.strips) {
    for (const fixes::KeyframeFix& one : strip.keyframes) {
      const FixRecord& fix = one.fix;
      out << "keyframe " << fix.id << ": " << name_of(fix.verdict);
      if (fixes::was_registered(fix)) {
        out << " by " << name_of(fix.sense) << ", evidence " << host::brief(fix.evidence) << " (" << fix.votes << " of "
            << fix.patches << " patches agree), prior position by " << name_of(fix.prior);
      }
      if (fix.verdict == MapVerdict::fixed) {
        const fixes::ErrorEllipse ellipse = fixes::ellipse_of(fix);
        out << ", ground at " << host::fixed(fix.ground_m[0], 1) << ", " << host::fixed(fix.ground_m[1], 1)
            << " m (error ellipse " << host::brief(ellipse.major_m) << " x " << host::brief(ellipse.minor_m)
            << " m, one sigma), " << host::brief(fix.pixel_m * std::hypot(fix.shift_px[0], fix.shift_px[1])) << " m ("
            << host::brief(fix.shift_sigmas) << " sigmas) from the prior, " << name_of(fix.state);
      }
      out << "\n";
    }
  }
}

nlohmann::ordered_json json_of(const fixes::MapCheck& check) {
  return {{"body", name_of(check.body)},
          {"fixes", fixes::json_of(check.fixes)},
          {"in_flight", check.in_flight.empty() ? nlohmann::ordered_json(nullptr) : fixes::json_of(check.in_flight)},
          {"events", check.events}};
}

}  // namespace

int map_check_main(int argc, char** argv) {
  host::CommandLine app("ilp-ground map-check",
                        "Localises the keyframes of a flight that came down on a map, as the flight would have",
                        "ilp-ground map-check flight map --sun 120,35 --out fixes.json");
  fixes::MapCheckOptions options;
  Words words;
  add_options(app, words, options);
  if (const auto end = host::read_command_line(app, argc - 1, argv + 1)) return *end;
  try {
    read_words(words, options);
    const fixes::MapCheck check = fixes::check_map(options, std::cerr);
    print(check.fixes, std::cout);
    for (const std::string& event : check.events) std::cout << event << "\n";
    for (const std::string& line : fixes::lines_of(check.fixes)) std::cout << line << "\n";
    if (const auto lines = fixes::lines_of(check.in_flight); !lines.empty())
      std::cout << "In the flight: " << lines[0] << "\n";
    if (!words.out.empty())
      host::update_file(words.out, [&](std::ostream& out) { out << json_of(check).dump(1) << "\n"; });
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground map-check: " << error.what() << "\n";
    return 1;
  }
}

}  // namespace ilp::ground
