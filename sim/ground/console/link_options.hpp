// The options by which a ground station finds its flight.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "sim/ground/console/operator_console.hpp"

namespace ilp::console {

struct LinkOptions {
  std::string address;  ///< at which the flight listens
  std::string cfdp, cfdp_local, key, numbers, seal_files = "as-told", tailoring = "standard";
  bool tcp = false;
  std::uint16_t apid = 239, source = 1, spi = 0;
};

/// --tcp, --key, --spi, --numbers, --apid, --source and --tailoring.
void add_link_options(CLI::App& app, LinkOptions& options);
/// --cfdp, --cfdp-local and --seal-files, for a station that receives or sends files.
void add_file_link_options(CLI::App& app, LinkOptions& options);

/// Reads the key file. Throws std::runtime_error that names the option's mistake. The station takes no files.
[[nodiscard]] OperatorSettings operator_settings(const LinkOptions& options);

}  // namespace ilp::console
