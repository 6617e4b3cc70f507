// ilp-xtce [--mission FILE.ini] [--flat]: writes the XTCE database of a mission to standard output.

#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <string>

#include "sim/host/command_line.hpp"
#include "sim/host/mission_input.hpp"
#include "sim/host/version_line.hpp"
#include "sim/tools/docgen/xtce/database.hpp"

int main(int argc, char** argv) {
  try {
    ilp::host::CommandLine app(
        "ilp-xtce", "Writes the XTCE 1.2 database of a mission to standard output: telecommands, reports, parameters",
        "ilp-xtce --mission mission.ini > mission.xml");
    std::string mission;
    app.add_option("--mission", mission, "mission parameters, an .ini file; without it those of the default mission");
    bool flat = false;
    app.add_flag("--flat", flat,
                 "one SpaceSystem, for readers that know no nested ones; /ILP/events/X is then /ILP/events_X");
    app.set_version_flag("--version", ilp::host::version_line("ilp-xtce"));
    if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
    std::cout << ilp::docgen::xtce_database(ilp::host::read_mission(mission), flat) << std::flush;
  } catch (const std::exception& fault) {
    std::cerr << "ilp-xtce: " << fault.what() << "\n";
    return 1;
  }
  return std::cout ? 0 : 1;
}
