// The command-line options for a ground station's link to its flight.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "sim/ground/console/operator_console.hpp"

namespace ilp::console {

struct LinkOptions {
  std::string address;  ///< ADDRESS:PORT at which the flight listens
  std::string cfdp, cfdp_local, key, numbers, seal_files = "as-told", tailoring = "standard";
  bool tcp = false;
  std::uint16_t apid = 239, source = 1, spi = 0;
};

/// Adds --tcp, --key, --spi, --numbers, --apid, --source and --tailoring.
void add_link_options(CLI::App& app, LinkOptions& options);
/// Adds --cfdp, --cfdp-local and --seal-files, for a station that receives or sends files.
void add_file_link_options(CLI::App& app, LinkOptions& options);

/// Converts the options to settings, and reads the key file. The settings have no folder for files, so that the station
/// receives none. Throws std::runtime_error that says which option is wrong.
[[nodiscard]] OperatorSettings operator_settings(const LinkOptions& options);

}  // namespace ilp::console
